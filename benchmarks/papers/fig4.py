r"""Fig. 4 by both integrators on several grids, beside the paper's numbers: prints docs/fig4.md.

    python benchmarks/papers/fig4.py [--grids 32 64 128 256] [--explicit 32 64 128] \
        [--picture docs/fig4.png] > docs/fig4.md

Runs that are complete in the folder `--output` are not repeated. With the implicit integrator (--grids) 64 x 128 cells
take some seconds, each doubling about eight times that; with the explicit one (--explicit) 32 x 64 cells take a minute
or two, each doubling eight times that.
"""

from __future__ import annotations

import argparse
import json
import math
import shutil
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

from hydro.cli import main as hydro
from hydro.markdown import table

DECK = Path(__file__).parents[2] / "problems" / "fig4.toml"
TIMES = (100, 500, 1000, 1290)
PAPER = {"wall_max": (0.25, 0.46, 0.66, 0.74), "wall_min": (0.14, 0.072, 0.040, 0.036)}
NAMES = [f"{kind} at t={time}" for kind in ("max", "min") for time in TIMES]

IMPLICIT, EXPLICIT = "lagrange-remap", "godunov"
ROUND = ("gas.K=2e-3", "gas.tau=200", "initial.temperature=1")  # not fitted
VARIANTS = {
    "": ROUND,
    "a quarter of the tolerance": (*ROUND, "time.tolerance=7.5e-5"),
    "half the step": (*ROUND, "time.cfl=0.4"),
    "plain HLLC": (*ROUND, "scheme.riemann=hllc"),
    "MC": (*ROUND, "scheme.limiter=mc"),
    "as fitted": (),
}
FITTED, FINER_STEPS = "as fitted", "a quarter of the tolerance"
FINER_STEPS_ON = 64
EXPLICIT_VARIANTS_ON = 32
VARIANTS_OF_EXPLICIT = ("half the step", "plain HLLC", "MC")

HEAD = """# Fig. 4 beside the paper

Printed by `{command}`:
`problems/fig4.toml`, largest and smallest n on the wall x = 0 by both integrators. Rows marked "{fitted}" have K, tau
and T(0) of the deck, fitted to the paper's numbers ([calibration.md](calibration.md)); the others, which compare grids,
steps and integrators, have the round values {round}.

![Density at four times](fig4.png)

*Density on {picture} cells by `lagrange-remap`, {fitted}; below each map the range of n on the wall x = 0.*
"""


def folder_of(output: Path, integrator: str, nx: int, variant: str) -> Path:
    """Where a run is kept."""
    return output / f"{integrator}_{nx}{'_' if variant else ''}{variant.replace(' ', '_')}"


def summary(output: Path, integrator: str, nx: int, variant: str) -> dict:
    """The summary of one run; runs it if it is not there yet."""
    folder = folder_of(output, integrator, nx, variant)
    if not (folder / "summary.json").exists():
        words = [str(DECK), f"time.integrator={integrator}", f"mesh.cells=[{nx},{2 * nx}]", *VARIANTS[variant]]
        if hydro([*words, "--output", str(folder), "--quiet", "--overwrite"]):
            raise SystemExit(f"{folder.name} failed")
    return json.loads((folder / "summary.json").read_text())


def values(result: dict) -> list[float]:
    """The eight numbers of Fig. 4, maxima first."""
    return [row[key] for key in PAPER for row in result["snapshots"]]


def rms_log_ratio(numbers: list[float]) -> float:
    """Root mean square of the logarithms of the ratios to the paper's numbers."""
    paper = [*PAPER["wall_max"], *PAPER["wall_min"]]
    return math.sqrt(sum(math.log(a / b) ** 2 for a, b in zip(numbers, paper, strict=True)) / len(paper))


def row(label: str, numbers: list[float], rest: tuple[str, ...] = ("", "")) -> list[str]:
    """A row of the table: the numbers, the rms of the log ratios to the paper's, steps and seconds."""
    return [label, *(f"{number:.4f}" for number in numbers), f"{rms_log_ratio(numbers):.3f}", *rest]


def label_of(nx: int, variant: str) -> str:
    """Cells and variant."""
    return f"{nx} x {2 * nx}" + (f", {variant}" if variant else "")


def beside_the_paper(results: dict[tuple[int, str], dict]) -> str:
    """Runs beside the paper."""
    header = ["cells", *(f"max {time}" for time in TIMES), *(f"min {time}" for time in TIMES), "rms log ratio"]
    header += ["steps", "seconds"]
    rows = [row("paper", [*PAPER["wall_max"], *PAPER["wall_min"]])]
    for key, result in results.items():
        rest = (str(result["steps"]), f"{result['wall_seconds']:.1f}")
        rows.append(row(label_of(*key), values(result), rest))
    return table(header, rows)


def largest(one: list[float], other: list[float]) -> str:
    """Largest relative difference, and where."""
    size, name = max((abs(b / a - 1.0), name) for a, b, name in zip(one, other, NAMES, strict=True))
    return f"{size:.2%} ({name})"


def changes(implicit: dict[tuple[int, str], list[float]], explicit: dict[tuple[int, str], list[float]]) -> str:
    """Largest relative changes: with the grid, with the step, and between the integrators."""
    rows = []
    for name, numbers in ((IMPLICIT, implicit), (EXPLICIT, explicit)):
        for kind in ("", FITTED):
            for coarse, fine in pairwise(sorted(nx for nx, variant in numbers if variant == kind)):
                label = f"`{name}`{', ' * bool(kind)}{kind}, {coarse} -> {fine} cells in x"
                rows.append((label, largest(numbers[coarse, kind], numbers[fine, kind])))
        for nx, variant in sorted(numbers):
            if variant in ("half the step", FINER_STEPS):
                rows.append((f"`{name}`, {variant}, {nx}", largest(numbers[nx, ""], numbers[nx, variant])))
    for nx in sorted({nx for nx, _ in implicit} & {nx for nx, _ in explicit}):
        rows.append((f"`{EXPLICIT}` -> `{IMPLICIT}`, {nx} cells in x", largest(explicit[nx, ""], implicit[nx, ""])))
    return table(("change", "largest relative change of the eight numbers"), rows)


def order(first: float, second: float) -> str:
    """Order of convergence from two differences between grids; none where they do not shrink or change sign."""
    ratio = first / second if second else math.nan
    return f"{math.log2(ratio):.2f}" if ratio > 1.0 else "none"


def richardson(sequence: Sequence[float]) -> tuple[float, float]:
    """Limit for second order from the two finest of grids that double, and its error by the three finest."""
    first, second = sequence[-2] - sequence[-3], sequence[-1] - sequence[-2]
    return sequence[-1] + second / 3.0, abs(4.0 * second - first) / 3.0


def agreement(implicit: dict[int, list[float]], explicit: dict[int, list[float]], steps_error: list[float]) -> str:
    """Limits of both integrators from the grids that both have, and differences grid by grid."""
    grids = sorted(set(implicit) & set(explicit))
    header = ["number", f"`{IMPLICIT}`", f"`{EXPLICIT}`", "apart by", "errors together", ""]
    header += [f"difference, {nx} (change)" for nx in grids]
    rows = []
    for k, name in enumerate(NAMES):
        ours, theirs = [implicit[nx][k] for nx in grids], [explicit[nx][k] for nx in grids]
        (limit, error), (other, other_error) = richardson(ours), richardson(theirs)
        both, apart = error + other_error + steps_error[k], abs(limit - other)
        cells = [name, f"{limit:.5f} +- {error + steps_error[k]:.5f}", f"{other:.5f} +- {other_error:.5f}"]
        cells += [f"{apart:.5f}", f"{both:.5f}", "agree" if apart <= both else "**differ**"]
        changes = ["", *(f" ({b / a - 1.0:+.2%})" for a, b in pairwise(theirs))]
        cells += [f"{a / b - 1.0:+.2%}{change}" for a, b, change in zip(ours, theirs, changes, strict=True)]
        rows.append(cells)
    return table(header, rows)


def limits(numbers: dict[int, list[float]], steps_error: list[float]) -> str:
    """Observed orders and Richardson limits with their errors, from grids that double, and errors of the steps."""
    grids = sorted(numbers)
    triples = list(zip(grids, grids[1:], grids[2:], strict=False))
    header = [
        "number",
        "paper",
        *(f"order, {a}, {b}, {c}" for a, b, c in triples),
        "limit",
        "error, grid",
        "error, steps",
        "log(limit/paper)",
    ]
    rows, found, paper = [], [], [*PAPER["wall_max"], *PAPER["wall_min"]]
    for k, name in enumerate(NAMES):
        sequence = [numbers[nx][k] for nx in grids]
        steps = [b - a for a, b in pairwise(sequence)]
        orders = [order(a, b) for a, b in pairwise(steps)]
        limit, error = richardson(sequence)
        found.append(limit)
        cells = [name, f"{paper[k]:.3f}", *orders, f"{limit:.5f}", f"{error:.5f}", f"{steps_error[k]:.5f}"]
        cells.append(f"{math.log(limit / paper[k]):+.3f}")
        rows.append(cells)
    said = f"Rms of the eight log ratios of the limits to the paper's numbers: {rms_log_ratio(found):.3f}."
    return f"{table(header, rows)}\n\n{said}"


LIMITS = """
## Order in the grid, and limits

Orders are log2 of the ratio of successive differences; "none" where they do not shrink or change sign. The limit is
Richardson's for second order from the two finest grids, a3 + (a3 - a2)/3. The error of the grid is estimated by the
difference to the same limit from the grids before, |4 (a3 - a2) - (a2 - a1)|/3, which vanishes where the order is 2.
The error of the steps in time is 4/3 of the change by a quarter of the tolerance, which is half the step, on
{on} x {double} cells: the error of the default tolerance there, for second order.
"""

AGREEMENT = """
## Limits of both integrators

Limits and errors of the grid as above, both from the grids {grids} in x. The steps of `godunov` shrink with the cells,
so its limit is that of grid and step together; to the error of `lagrange-remap` that of its steps, above, is added.
Then relative differences, `lagrange-remap` from `godunov`, grid by grid; in brackets the change of `godunov` from the
grid before.
"""


def conservation(name: str, results: dict[tuple[int, str], dict]) -> str:
    """The worst mass drift and energy residual."""
    drift = max(abs(result["mass_drift"]) for result in results.values())
    residual = max(abs(result["energy_ledger"]["residual"]) for result in results.values())
    return f"`{name}`: largest mass drift {drift:.1e}, largest energy residual {residual:.1e} of the wall's input."


def main() -> None:
    """Run what is missing and print the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--grids", type=int, nargs="*", default=[32, 64, 128, 256], help="of the implicit integrator")
    parser.add_argument(
        "--explicit", type=int, nargs="*", default=[32, 64, 128], help="grids of the explicit integrator"
    )
    parser.add_argument("--output", type=Path, default=Path("output/fig4_grids"))
    parser.add_argument("--picture", type=Path, help="copy the picture of 128 x 256 cells, or of the finest grid")
    options = parser.parse_args()
    wanted = [(nx, variant) for variant in ("", FITTED) for nx in options.grids]
    wanted += [(nx, FINER_STEPS) for nx in options.grids if nx == FINER_STEPS_ON]
    implicit = {key: summary(options.output, IMPLICIT, *key) for key in wanted}
    wanted = [(nx, "") for nx in options.explicit]
    wanted += [(nx, name) for name in VARIANTS_OF_EXPLICIT for nx in options.explicit if nx == EXPLICIT_VARIANTS_ON]
    explicit = {key: summary(options.output, EXPLICIT, *key) for key in wanted}
    by_implicit = {key: values(result) for key, result in implicit.items()}
    by_explicit = {key: values(result) for key, result in explicit.items()}

    shown = 128 if 128 in options.grids else max(options.grids, default=0)
    if options.picture and shown:
        shutil.copyfile(
            folder_of(options.output, IMPLICIT, shown, FITTED) / "pictures" / "density.png", options.picture
        )
    words = ["--grids", *map(str, options.grids), "--explicit", *map(str, options.explicit)]
    words += ["--picture", str(options.picture)] if options.picture else []
    command = f"python benchmarks/papers/fig4.py {' '.join(words)}"
    print(HEAD.format(command=command, picture=f"{shown} x {2 * shown}", fitted=FITTED, round=", ".join(ROUND)))
    if implicit:
        print("## The implicit integrator `lagrange-remap`\n")
        print(beside_the_paper(implicit), "", conservation(IMPLICIT, implicit), sep="\n")
    if explicit:
        print("\n## The explicit integrator `godunov`\n")
        print(beside_the_paper(explicit), "", conservation(EXPLICIT, explicit), sep="\n")
    print("\n## Changes\n")
    print(changes(by_implicit, by_explicit))
    found = {nx: numbers for (nx, variant), numbers in by_implicit.items() if not variant}
    if len(found) > 2:
        finer = by_implicit.get((FINER_STEPS_ON, FINER_STEPS))
        pairs = zip(found[FINER_STEPS_ON], finer, strict=True) if finer else ()
        errors = [4.0 / 3.0 * abs(a - b) for a, b in pairs] or [math.nan] * len(NAMES)
        print(LIMITS.format(on=FINER_STEPS_ON, double=2 * FINER_STEPS_ON))
        print(limits(found, errors))
        others = {nx: numbers for (nx, variant), numbers in by_explicit.items() if not variant}
        if len(grids := sorted(set(found) & set(others))) > 2:
            print(AGREEMENT.format(grids=", ".join(map(str, grids))))
            print(agreement(found, others, errors))


if __name__ == "__main__":
    main()
