"""Branches of localized states in boxes of aspect ratio 1, 2 and 3: bifurcations, folds, hysteresis.

    python benchmarks/papers/branches.py docs > docs/branches.md

Runs `problems/branches.toml` with the overrides shown, and draws all of it into branches.png and branches.pdf.
"""

from __future__ import annotations

import json
import sys
import tempfile
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from hydro.cli import main as hydro
from hydro.markdown import table
from hydro.pictures.branches import LABELS, branches_of, draw_densities, legend, mark
from hydro.pictures.style import publish

DECK = Path(__file__).parents[2] / "problems" / "branches.toml"
RUNS = {
    "half-wave, $\\Delta=1$": ("box.aspect_ratio=1", "branch.start=0.012", "branch.stop=0.034", "branch.step=0.1"),
    "half-wave, $\\Delta=2$": (),
    "full wave, $\\Delta=2$": (
        "branch.wave=2", "mesh.cells=[64,128]", "branch.start=0.012", "branch.stop=0.034", "branch.step=0.1",
    ),
    "half-wave, $\\Delta=3$": ("box.aspect_ratio=3", "mesh.cells=[64,96]", "branch.start=0.0075", "branch.stop=0.09"),
    "half-wave, $f=0.0235$": (
        "gas.f=0.0235", "branch.parameter=aspect_ratio", "branch.start=0.55", "branch.stop=1.2", "branch.step=0.1",
    ),
    "half-wave, $f=0.0235$, $\\Delta=1$": (
        "gas.f=0.0235", "box.aspect_ratio=1", "branch.parameter=L", "branch.start=2e4", "branch.stop=1e5",
        "branch.step=0.1",
    ),
}  # fmt: skip

HEAD = """# Branches of localized states

Written by `python benchmarks/papers/branches.py docs > docs/branches.md`: the deck `problems/branches.toml` (L = 5e4)
and five variants of it. What it means is said in [steady.md](steady.md).

![Bifurcation diagrams](branches.png)

*Largest (black) and smallest (gray) density on the wall x = 0 of the localized states; blue: the extended state. Stable
states solid, unstable ones dashed, to all perturbations that fit into the box.*
"""


def summary_of(overrides: tuple[str, ...], folder: Path) -> dict[str, Any]:
    """Run the deck."""
    code = hydro([str(DECK), *overrides, "--output", str(folder), "--quiet"])
    if code:
        raise SystemExit(code)
    return json.loads((folder / "summary.json").read_text())


def rows_of(name: str, summary: dict[str, Any]) -> list[tuple[str, ...]]:
    """Bifurcations and folds of a run, as rows."""
    parameter = summary["parameter"]
    entries = [(entry, f"{entry['direction']} bifurcation") for entry in summary["bifurcations"]]
    entries += [(entry, "fold") for entry in summary["folds"]]
    entries += [(entry, f"{entry['sector']} growth changes sign") for entry in summary["secondary"]]
    found: list[tuple[str, ...]] = [
        (name, kind, f"{parameter} = {e[parameter]:.5g}", f"{e['wall_max']:.4f}") for e, kind in entries
    ]
    for entry in summary["hysteresis"]:
        low, high = sorted((entry["from"], entry["to"]))
        found.append((name, "hysteresis", f"{parameter} = {low:.5g} to {high:.5g}", ""))
    return found


def main(folder: Path) -> None:
    """Print the table and draw the picture."""
    figure = Figure(figsize=(11.0, 6.6), layout="constrained")
    axes = figure.subplots(2, 3).ravel()
    print(HEAD)
    found = []
    with tempfile.TemporaryDirectory() as scratch:
        for number, (axis, (name, overrides)) in enumerate(zip(axes, RUNS.items(), strict=True)):
            summary = summary_of(overrides, Path(scratch) / str(number))
            found += rows_of(name.replace("$", "").replace("\\Delta", "Delta"), summary)
            for rows in branches_of(summary):
                draw_densities(axis, rows, summary["parameter"])
            mark(axis, summary, summary["parameter"])
            axis.set_title(f"({'abcdef'[number]})  {name}", fontsize=10)
            axis.set_xlabel(LABELS[summary["parameter"]])
            axis.set_ylim(0.0, 1.02)
    print(table(("states", "what", "where", "largest n(0,y)"), found))
    for axis in axes[::3]:
        axis.set_ylabel("$n/n_c$ on the wall $x=0$")
    axes[0].legend(handles=list(legend()), fontsize=7)
    publish(figure, folder / "branches")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
