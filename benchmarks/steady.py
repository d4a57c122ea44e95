"""Seconds of the steady and stability solvers: `python benchmarks/steady.py`, a section of docs/performance.md."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from statistics import median
from typing import Any

import numpy as np
from measure import processor

from hydro.gas import Grossman
from hydro.markdown import table
from hydro.mesh import Mesh
from hydro.steady.balance import Balance
from hydro.steady.bifurcation import ExtendedBranch
from hydro.steady.continuation import Family, follow
from hydro.steady.extended import extended_state
from hydro.steady.growth import growth_of
from hydro.steady.localized import steady_state
from hydro.steady.marginal import critical_aspect_ratio, tongue
from hydro.walls import VibratingWall

GAS, WALL, TAU, F = Grossman(L=5e4, K=2e-3), VibratingWall(strength=0.228), 200.0, 0.0235
GRIDS = (32, 64, 128)
BRANCH = (0.0268, 0.034)  # from the bifurcation of a half-wave in a box of aspect ratio 2
WALLS = ("vibrating", "thermal")
ROUNDS = 3


def seconds(action: Callable[[], Any]) -> tuple[float, Any]:
    """Median of some rounds, and what the last one gave; one before them compiles and loads."""
    result, taken = action(), []
    for _ in range(ROUNDS):
        started = time.perf_counter()
        result = action()
        taken.append(time.perf_counter() - started)
    return median(taken), result


def states() -> str:
    """A localized state from nothing, and its leading growth rates, grid by grid."""
    rows = []
    for cells in GRIDS:
        mesh = Mesh.rectangle((cells, 2 * cells), 2.0)
        for wave, name in ((1, "half-wave"), (2, "full wave")):
            taken, steady = seconds(partial(steady_state, GAS, WALL, mesh, F, wave))
            growth, _ = seconds(partial(growth_of, steady, TAU, 1))
            grid = f"{cells} x {2 * cells}"
            rows.append([name, grid, steady.iterations, f"{steady.residual:.0e}", f"{taken:.2f}", f"{growth:.2f}"])
    header = ["state", "cells", "Newton iterations, all meshes", "residual", "seconds", "seconds, growth rates"]
    return f"""### Localized states

Fig. 3, points 1 and 2 in the box of aspect ratio 2: from the extended state, over coarser meshes. A full wave is solved
for on its half. Growth rates: the leading one of each symmetry.

{table(header, rows)}"""


def branch() -> str:
    """A branch with its bifurcation and fold."""
    rows = []
    for cells in GRIDS:
        family = Family(Balance.of(GAS, WALL, Mesh.rectangle((cells, 2 * cells), 2.0), F), "f")

        def points(family: Family = family) -> list[Any]:
            (start,) = ExtendedBranch(family).bifurcations(np.linspace(0.029, 0.034, 9))
            return list(follow(family, start, BRANCH, 0.2))

        taken, found = seconds(points)
        rows.append([f"{cells} x {2 * cells}", len(found), f"{taken:.2f}", f"{taken / len(found):.3f}"])
    return "### A subcritical branch from its bifurcation past its fold\n\n" + table(
        ["cells", "points", "seconds", "seconds per point"], rows
    )


def stability() -> str:
    """Extended states, their critical aspect ratios, and tongues."""
    rows = []
    for L in (1e3, 5e4, 1e6):
        gas = Grossman(L=L, K=1.0)
        state_s, state = seconds(partial(extended_state, gas, F))
        marks = [seconds(partial(critical_aspect_ratio, state, wall))[0] for wall in WALLS]
        tongues = [seconds(partial(tongue, gas, wall))[0] for wall in WALLS]
        rows.append([f"{L:g}", *(f"{1e3 * s:.2g}" for s in (state_s, *marks)), *(f"{s:.2g}" for s in tongues)])
    walls = [f"critical ratio, {wall} wall, ms" for wall in WALLS] + [f"tongue, {wall} wall, s" for wall in WALLS]
    return "### Marginal stability\n\n" + table(["L", "extended state, ms", *walls], rows)


def report() -> None:
    """Print the section."""
    print("## Steady states and stability\n")
    print(f"Printed by `python benchmarks/steady.py`: medians of {ROUNDS}, after compilation. {processor()}.")
    for part in (states, branch, stability):
        print("\n" + part(), flush=True)


if __name__ == "__main__":
    report()
