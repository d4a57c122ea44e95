"""The sides of the box as data: what each wall does to the row of cells beside it.

A law fills the arrays of its side in kernels of its own, and sweeps only read these arrays. So a sweep is compiled once
whatever the laws are, and a new law costs its own kernels only.
"""

from __future__ import annotations

import itertools
import math
from typing import Any, NamedTuple

import numpy as np
from numba import literal_unroll

from hydro.errors import StepRejected
from hydro.fields import N, P, U, V
from hydro.gas import Closure
from hydro.jit import kernel
from hydro.mesh import GHOSTS, Geometry, Mesh
from hydro.walls.elastic import ElasticWall
from hydro.walls.sides import Walls
from hydro.walls.vibrating import VibratingWall

LOW, HIGH = 0, 1  # the sides x = 0 and x = 1 of `x`, and y = 0 and y = aspect ratio of `y`

# Rows of a side, each with an entry for every cell along it.
HEAT = 0  # heat into the gas, per length and time
HEAT_N, HEAT_T = 1, 2  # its slopes in density and temperature of the cell
TEMPERATURE = 3  # of the wall face; zero until a law has found it
FLOW = (
    4  # momentum density of the gas through the side, along x or y; `lagrange-remap` reads it, and no law fills it yet
)
STRESS = 5  # force along the side on the gas, per length, on corners, so with an entry more; no law fills it yet
ROWS = 6

# Long name and unit of what a boundary remembers.
REMEMBERED = {
    f"wall_temperature_{side}": (f"temperature of the wall {side}, first guess of the next", "T_*")
    for side in ("x0", "x1", "y0", "y1")
}


class Sides(NamedTuple):
    """What sweeps read of the four sides of a mesh of (nx, ny) cells."""

    x: np.ndarray  # (2, ROWS, ny + 1)
    y: np.ndarray  # (2, ROWS, nx + 1)
    ghost_x: np.ndarray  # (2, GHOSTS, 4, ny), primitive fields of the rows beyond, the nearest first
    ghost_y: np.ndarray  # (2, GHOSTS, 4, nx + 2 GHOSTS), with the corners of the box

    @classmethod
    def of(cls, mesh: Mesh) -> Sides:
        nx, ny = mesh.cells
        return cls(
            np.zeros((2, ROWS, ny + 1)), np.zeros((2, ROWS, nx + 1)),
            np.zeros((2, GHOSTS, 4, ny)), np.zeros((2, GHOSTS, 4, nx + 2 * GHOSTS)),
        )  # fmt: skip


class HeatedSide(NamedTuple):
    """A side whose law gives heat."""

    name: str
    law: Any
    rows: np.ndarray  # (ROWS, m) of `Sides`
    lengths: np.ndarray  # (m,), of its faces
    half_width: float  # from the wall to the centres of its cells
    cells: tuple[Any, Any]  # where they are in a field (nx, ny)


class Heater(NamedTuple):
    """A heated side as kernels see it, with room for what is beside it."""

    law: Any
    rows: np.ndarray  # (ROWS, m) of `Sides`
    lengths: np.ndarray  # (m,)
    half_width: float
    axis: int
    last: int  # number of the row or column of cells beside it
    density: np.ndarray  # (m,)
    temperature: np.ndarray  # (m,)


class Boundary:
    """The four sides of a box: their laws, and the arrays that these fill.

    walls: `Walls`, or the law of the driving wall alone. A periodic direction has no walls.
    """

    def __init__(self, gas: Closure, walls: Any, mesh: Mesh):
        self.gas, self.walls, self.mesh, self.sides = gas, Walls.of(walls), mesh, Sides.of(mesh)
        self.heated = tuple(self._heated()) if gas.conducts() else ()

    def _heated(self):
        geometry, sides = Geometry.of(self.mesh), self.sides
        for axis, end in itertools.product((0, 1), (LOW, HIGH)):
            name, last = f"{'xy'[axis]}{end}", -end
            law = getattr(self.walls, name)
            if self.mesh.periodic[axis] or not hasattr(law, "face"):
                continue
            if axis == 0:
                lengths, half_width, rows = geometry.scale_x[last] * geometry.dy, 0.5 * geometry.dx[last], sides.x
            else:
                lengths, half_width, rows = geometry.dx, 0.5 * geometry.dy[last], sides.y
            place = (last, slice(None)) if axis == 0 else (slice(None), last)
            yield HeatedSide(name, law, rows[end, :, :-1], lengths, half_width, place)

    def heaters(self, density: np.ndarray) -> tuple[Heater, ...]:
        """The heated sides as kernels see them, for a density (nx, ny) that stays; or one of no cells."""
        if not self.heated:
            nothing = np.zeros(0)
            return (Heater(VibratingWall(0.0), np.zeros((ROWS, 0)), nothing, 1.0, 0, 0, nothing, nothing),)
        found = []
        for side, n in zip(self.heated, self.beside(density), strict=True):
            axis, end = "xy".index(side.name[0]), int(side.name[1])
            last = end * (density.shape[axis] - 1)
            found.append(Heater(side.law, side.rows, side.lengths, side.half_width, axis, last, n, np.empty_like(n)))
        return tuple(found)

    def reflect(self, axis: int) -> None:
        """Turn the images that the ghost rows along an axis hold into what lies beyond its two walls."""
        if not self.mesh.periodic[axis]:
            laws, ghosts = self.walls[2 * axis : 2 * axis + 2], (self.sides.ghost_x, self.sides.ghost_y)[axis]
            for law, rows in zip(laws, ghosts, strict=True):
                reflect(law if hasattr(law, "beyond") else ElasticWall(), axis, rows)

    def beside(self, field: np.ndarray) -> list[np.ndarray]:
        """Of a field (nx, ny), the values beside every heated side; each (m,) and contiguous."""
        return [np.ascontiguousarray(field[side.cells]) for side in self.heated]

    def give_heat(self, densities: list[np.ndarray], temperatures: list[np.ndarray]) -> float:
        """Have the laws find their heat for fields as from `beside`; returns the power that the walls give.

        StepRejected where a law finds none.
        """
        power = 0.0
        for side, n, T in zip(self.heated, densities, temperatures, strict=True):
            given = fill_heat(side.law, self.gas, n, T, side.half_width, side.lengths, side.rows)
            if math.isnan(given):
                refuse_no_heat(side, n, T)
            power += given
        return power

    def give_slopes(self, densities: list[np.ndarray], temperatures: list[np.ndarray]) -> None:
        """Have the laws find the slopes of the heat that `give_heat` has found."""
        for side, n, T in zip(self.heated, densities, temperatures, strict=True):
            fill_slopes(side.law, self.gas, n, T, side.half_width, side.rows)

    def temperatures(self) -> dict[str, np.ndarray]:
        """Temperatures of the heated sides, first guesses of the next, by name; copies."""
        return {f"wall_temperature_{side.name}": side.rows[TEMPERATURE].copy() for side in self.heated}

    def take_temperatures(self, memory: dict[str, np.ndarray]) -> None:
        """Take back what `temperatures` gave."""
        for side in self.heated:
            side.rows[TEMPERATURE] = memory[f"wall_temperature_{side.name}"]


def refuse_no_heat(side: HeatedSide, n: np.ndarray, T: np.ndarray) -> None:
    """StepRejected where a law finds no heat for gas that is as it should be."""
    no_heat = np.isnan(side.rows[HEAT]) & (n > 0.0) & (T > 0.0) & np.isfinite(n * T)
    if no_heat.any():
        j = int(np.argmax(no_heat))
        raise StepRejected(
            f"the law of the wall {side.name} finds no heat for n = {n[j]:.4g}, T = {T[j]:.4g} beside it"
        )


def wall_heat(gas: Closure, law: Any, density: np.ndarray, temperature: np.ndarray, half_width: float):
    """(heat flux, temperature) of the wall face, for cells beside it of density and temperature (m,); both (m,)."""
    rows = np.zeros((ROWS, density.size))
    if hasattr(law, "face") and gas.conducts():
        fill_heat(law, gas, density, temperature, half_width, np.ones(density.size), rows)
        return rows[HEAT], rows[TEMPERATURE]
    return rows[HEAT], temperature.copy()


@kernel(exact=True)
def fill_heat(law, gas, density, temperature, half_width, lengths, rows):
    """Heat and wall temperature of a side, into `rows`, for the cells beside it; returns its power. All (m,)."""
    heat, guess = rows[HEAT], rows[TEMPERATURE]
    power = 0.0
    for j in range(density.size):
        start = guess[j] if guess[j] > 0.0 else temperature[j]
        heat[j], guess[j] = law.face(gas, density[j], temperature[j], half_width, start)
        power += heat[j] * lengths[j]
    return power


@kernel
def heat_of(heaters, gas, temperature):
    """Have the laws find their heat for a temperature (nx, ny); returns the power that the walls give."""
    power = 0.0
    for side in literal_unroll(heaters):
        for j in range(side.temperature.size):
            i, k = (side.last, j) if side.axis == 0 else (j, side.last)
            side.temperature[j] = temperature[i, k]
        power += fill_heat(side.law, gas, side.density, side.temperature, side.half_width, side.lengths, side.rows)
    return power


@kernel(exact=True)
def fill_slopes(law, gas, density, temperature, half_width, rows):
    """Slopes of the heat of a side, into `rows`, for the wall temperatures that `fill_heat` found there."""
    for j in range(density.size):
        rows[HEAT_N, j], rows[HEAT_T, j] = law.face_slopes(
            gas, density[j], temperature[j], half_width, rows[TEMPERATURE, j]
        )


@kernel(exact=True)
def reflect(law, axis, ghosts):
    """Turn images of the cells beside a wall, (GHOSTS, 4, m), into what lies beyond it, in place."""
    normal, tangential = (U, V) if axis == 0 else (V, U)
    for ghost in range(ghosts.shape[0]):
        row = ghosts[ghost]
        for j in range(row.shape[1]):
            row[N, j], row[normal, j], row[tangential, j], row[P, j] = law.beyond(
                row[N, j], row[normal, j], row[tangential, j], row[P, j]
            )
