"""Fig. 3 of the paper: which states its points 3 and 4 are, how their numbers depend on the mesh, and the picture.

    python benchmarks/papers/fig3.py docs > docs/fig3.md

The folder gets the picture (fig3.png and fig3.pdf) and a bifurcation diagram. Point 3 is looked for on the half-wave
branch at Delta = 2, point 4 on the full-wave branch, that is the half-wave branch at Delta = 1 and its mirror image.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

from hydro.gas import Grossman
from hydro.markdown import table
from hydro.mesh import Mesh
from hydro.observables.clustering import CLUSTERING, gas_density, wall_extremes
from hydro.pictures.density import Map, density_panels
from hydro.steady.balance import Balance
from hydro.steady.bifurcation import ExtendedBranch
from hydro.steady.continuation import Family, Point, follow
from hydro.steady.growth import growth_of
from hydro.steady.localized import SteadyState, steady_state
from hydro.steady.newton import solve
from hydro.walls import VibratingWall

GAS, WALL, TAU = Grossman(L=5e4, K=2e-3), VibratingWall(strength=0.228), 200.0
GRIDS = (32, 64, 128, 256)  # cells in x, and per unit length in y
F = 0.0235
POINTS = {  # label: (wave, aspect ratio, largest and smallest density on the wall in the paper)
    "1": (1, 1.0, 0.76, 0.036),
    "2": (2, 2.0, 0.76, 0.036),
    "3": (1, 2.0, 0.48, 0.21),
    "4": (2, 2.0, 0.54, 0.10),
}
LAST_DIGIT = 0.005  # half a unit of the last digit of the paper's numbers for points 3 and 4
LIMITS = {"3": (0.029, 0.034), "4": (0.0268, 0.02955)}
STEP = 0.1


def cell_of(label: str, cells: int) -> Mesh:
    """The mesh of one half-wave."""
    wave, aspect_ratio, _, _ = POINTS[label]
    width = aspect_ratio / wave
    return Mesh.rectangle((cells, round(cells * width)), width)


def branch_points(label: str, cells: int) -> tuple[Family, list[Point]]:
    """The subcritical branch near the point, as far as its densities are still below the fold's."""
    family = Family(Balance.of(GAS, WALL, cell_of(label, cells), F), "f")
    (start,) = ExtendedBranch(family).bifurcations(np.linspace(*LIMITS[label], 9))
    points = []
    for point in follow(family, start, LIMITS[label], STEP):
        if point.tangent[-1] < 0.0:
            break
        points.append(point)
    return family, points


def extremes(family: Family, point: Point, value: float) -> tuple[np.ndarray, float, float]:
    """Unknowns, smallest and largest density on the wall at f = value, from the nearby point."""
    problem = family.at(math.log(value))
    unknowns = solve(problem, point.vector[:-1]).unknowns
    return unknowns, *wall_extremes(problem.state(unknowns).density, problem.mesh)


def f_where(family: Family, points: list[Point], which: int, wanted: float) -> float:
    """The f at which the smallest (1) or largest (2) density on the wall is `wanted`."""

    def excess(value: float) -> float:
        near = min(points, key=lambda point: abs(point.value - value))
        return float(extremes(family, near, value)[which]) - wanted

    return brentq(excess, points[0].value, points[-1].value, xtol=1e-8)


def identification(label: str) -> list[tuple[object, ...]]:
    """The f at which the densities round to the paper's, mesh by mesh."""
    _, _, high, low = POINTS[label]
    rows: list[tuple[object, ...]] = []
    for cells in GRIDS[:3]:
        family, points = branch_points(label, cells)
        from_max = sorted(f_where(family, points, 2, high + side * LAST_DIGIT) for side in (-1, 1))
        from_min = sorted(f_where(family, points, 1, low + side * LAST_DIGIT) for side in (-1, 1))
        both = (max(from_max[0], from_min[0]), min(from_max[1], from_min[1]))
        verdict = f"{both[0]:.5f} to {both[1]:.5f}" if both[0] <= both[1] else "none"
        ranges = [f"{ends[0]:.5f} to {ends[1]:.5f}" for ends in (from_max, from_min)]
        rows.append((label, cells, *ranges, verdict))
    return rows


def states(label: str, value: float) -> list[SteadyState]:
    """The state of a point on every grid."""
    wave, aspect_ratio, _, _ = POINTS[label]
    search = "branch" if label in LIMITS else "relaxation"
    found = []
    for cells in GRIDS:
        mesh = Mesh.rectangle((cells, round(cells * aspect_ratio)), aspect_ratio)
        found.append(steady_state(GAS, WALL, mesh, value, wave, search=search))
    return found


def row_of(label: str, value: float, steady: SteadyState) -> tuple[str, ...]:
    """A state in numbers."""
    state = steady.state
    low, high = wall_extremes(state.density, state.mesh)
    rates = "; ".join(f"{growth.rate:.3g} ({growth.sector})" for growth in growth_of(steady, TAU, 1))
    nx, ny = state.mesh.cells
    gas = gas_density(state, WALL)
    return label, f"{value:g}", f"{nx} x {ny}", f"{high:.4f}", f"{low:.5f}", f"{gas:.5f}", rates


def main(folder: Path) -> None:
    """Print the tables and draw the picture."""
    values = {"1": F, "2": F, "3": 0.0319, "4": 0.02895}
    print("# Fig. 3: four steady states\n")
    print("Written by `python benchmarks/papers/fig3.py docs > docs/fig3.md`.\n\n![Four states](fig3.png)\n")
    print("## Where points 3 and 4 are\n")
    print("The paper gives their largest and smallest density on the wall `x = 0` (0.48 and 0.21, 0.54 and 0.10) and")
    print("the line `Delta = 2`, but not `f`. Intervals of `f` in which each number rounds to the paper's:\n")
    header = ("point", "cells in x", "f from the largest", "f from the smallest", "both")
    print(table(header, [row for label in LIMITS for row in identification(label)]), flush=True)
    print("\n## The states, mesh by mesh\n\nGrowth rates for K = 2e-3, tau = 200, W = 114.\n")
    maps, rows = [], []
    for label, value in values.items():
        found = states(label, value)
        rows += [row_of(label, value, steady) for steady in found]
        state = found[2].state
        title = rf"point {label}, $f={value:g}$, $\Delta={state.mesh.aspect_ratio:g}$"
        maps.append(Map(state.density, state.mesh, title, CLUSTERING.span.note(state.density, state.mesh)))
    print(table(("point", "f", "cells", "largest n(0,y)", "smallest", "gas n at x=1", "growth rate"), rows))
    density_panels(folder / "fig3", maps)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
