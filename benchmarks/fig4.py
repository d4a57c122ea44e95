"""Fig. 4 on several grids and with halved steps, beside the paper's numbers: prints docs/fig4.md.

python benchmarks/fig4.py [--grids 32 64] [--output FOLDER]. Runs that are complete in FOLDER are not repeated.
On one core 32 x 64 takes about a minute, each doubling eight times that.
"""

from __future__ import annotations

import argparse
import json
import math
from itertools import pairwise
from pathlib import Path

from hydro.cli import main as hydro

DECK = Path(__file__).parent.parent / "problems" / "fig4.toml"
TIMES = (100, 500, 1000, 1290)
PAPER = {"wall_max": (0.25, 0.46, 0.66, 0.74), "wall_min": (0.14, 0.072, 0.040, 0.036)}
VARIANTS = {
    "": [],
    "half the step": ["time.cfl=0.4"],
    "plain HLLC": ["scheme.riemann=hllc"],
    "MC": ["scheme.limiter=mc"],
}
ALL_VARIANTS_ON = 32
HALVED_ON = (32, 64)


def summary(folder: Path, nx: int, variant: str) -> dict:
    """The summary of one run; runs it if it is not there yet."""
    name = f"{nx}{variant.replace(' ', '_')}"
    if not (folder / name / "summary.json").exists():
        words = [str(DECK), f"mesh.cells=[{nx},{2 * nx}]", *VARIANTS[variant], "--output", str(folder / name)]
        if hydro([*words, "--quiet", "--overwrite"]):
            raise SystemExit(f"{name} failed")
    return json.loads((folder / name / "summary.json").read_text())


def values(result: dict) -> list[float]:
    """The eight numbers of Fig. 4, maxima first."""
    return [row[key] for key in PAPER for row in result["snapshots"]]


def row(label: str, numbers: list[float]) -> str:
    """A row of the table, with the rms of the log ratios to the paper's numbers."""
    paper = [*PAPER["wall_max"], *PAPER["wall_min"]]
    rms = math.sqrt(sum(math.log(a / b) ** 2 for a, b in zip(numbers, paper, strict=True)) / len(paper))
    return f"| {label} | " + " | ".join(f"{number:.4f}" for number in numbers) + f" | {rms:.3f} |"


def table(results: dict[tuple[int, str], dict]) -> list[str]:
    """All runs beside the paper."""
    header = ["cells", *(f"max {time}" for time in TIMES), *(f"min {time}" for time in TIMES), "rms log ratio"]
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    lines.append(row("paper", [*PAPER["wall_max"], *PAPER["wall_min"]]))
    for (nx, variant), result in results.items():
        lines.append(row(f"{nx} x {2 * nx}" + (f", {variant}" if variant else ""), values(result)))
    return lines


def changes(results: dict[tuple[int, str], dict]) -> list[str]:
    """Largest relative change of the eight numbers between neighbouring grids, and by halving the step."""
    lines = []
    grids = sorted(nx for nx, variant in results if not variant)
    for coarse, fine in pairwise(grids):
        lines.append(f"| {coarse} -> {fine} cells in x | {largest(results[coarse, ''], results[fine, ''])} |")
    for nx in grids:
        if (nx, "half the step") in results:
            lines.append(f"| half the step, {nx} | {largest(results[nx, ''], results[nx, 'half the step'])} |")
    return ["| change | largest relative change of the eight numbers |", "|---|---|", *lines]


def largest(one: dict, other: dict) -> str:
    """Largest relative difference, and where."""
    names = [f"{kind} at t={time}" for kind in ("max", "min") for time in TIMES]
    size, name = max((abs(b / a - 1.0), name) for a, b, name in zip(values(one), values(other), names, strict=True))
    return f"{size:.2%} ({name})"


def conservation(results: dict[tuple[int, str], dict]) -> str:
    """The worst mass drift and energy residual."""
    drift = max(abs(result["mass_drift"]) for result in results.values())
    residual = max(abs(result["energy_ledger"]["residual"]) for result in results.values())
    return f"Largest mass drift of these runs {drift:.1e}, largest energy residual {residual:.1e} of the wall's input."


def main() -> None:
    """Run what is missing and print the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--grids", type=int, nargs="+", default=[32, 64])
    parser.add_argument("--output", type=Path, default=Path("output/fig4_grids"))
    options = parser.parse_args()
    wanted = [(nx, "") for nx in options.grids]
    wanted += [(nx, "half the step") for nx in options.grids if nx in HALVED_ON]
    wanted += [(ALL_VARIANTS_ON, name) for name in VARIANTS if name not in ("", "half the step")]
    results = {key: summary(options.output, *key) for key in wanted}
    print("# Fig. 4 beside the paper\n")
    command = f"python benchmarks/fig4.py --grids {' '.join(map(str, options.grids))}"
    print(f"Printed by `{command}`: `problems/fig4.toml`, largest and smallest n on the wall x = 0.\n")
    print("\n".join([*table(results), "", *changes(results), "", conservation(results)]))


if __name__ == "__main__":
    main()
