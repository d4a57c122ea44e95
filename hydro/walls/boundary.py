"""The sides of the box as data: what each wall does to the row of cells beside it.

A law fills the arrays of its side in kernels of its own, and sweeps only read these arrays. So a sweep is compiled once
whatever the laws are, and a new law costs its own kernels only.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
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


class Heater(NamedTuple):
    """A side whose law gives heat, as kernels see it, with room for what is beside it."""

    law: Any
    rows: np.ndarray  # (ROWS, m) of `Sides`
    lengths: np.ndarray  # (m,), of its faces
    half_width: float  # from the wall to the centres of its cells
    axis: int
    last: int  # number of the row or column of cells beside it
    density: np.ndarray  # (m,)
    temperature: np.ndarray  # (m,)


# Where no side gives heat, for kernels need one.
NO_HEATER = Heater(VibratingWall(0.0), np.zeros((ROWS, 0)), np.zeros(0), 1.0, 0, 0, np.zeros(0), np.zeros(0))


class Boundary:
    """The four sides of a box: their laws, and the arrays that these fill.

    walls: `Walls`, or the law of the driving wall alone. A periodic direction has no walls.
    """

    def __init__(self, gas: Closure, walls: Any, mesh: Mesh):
        self.gas, self.walls, self.mesh, self.sides = gas, Walls.of(walls), mesh, Sides.of(mesh)
        self.heaters = dict(self._heaters()) if gas.conducts() else {}
        self.laws_of_heat = tuple(self.heaters.values()) or (NO_HEATER,)
        self.laws_beyond = tuple(law if hasattr(law, "beyond") else ElasticWall() for law in self.walls)

    def _heaters(self) -> Iterator[tuple[str, Heater]]:
        """The sides that give heat, by name."""
        geometry = Geometry.of(self.mesh)
        for axis, end in itertools.product((0, 1), (LOW, HIGH)):
            name, last = f"{'xy'[axis]}{end}", end * (self.mesh.cells[axis] - 1)
            law = getattr(self.walls, name)
            if self.mesh.periodic[axis] or not hasattr(law, "face"):
                continue
            if axis == 0:
                lengths, width, rows = geometry.scale_x[-end] * geometry.dy, geometry.dx[last], self.sides.x
            else:
                lengths, width, rows = geometry.dx, geometry.dy[last], self.sides.y
            beside = np.zeros((2, lengths.size))
            yield name, Heater(law, rows[end, :, :-1], lengths, 0.5 * width, axis, last, *beside)

    def give_heat(self, density: np.ndarray, temperature: np.ndarray) -> float:
        """Have the laws find their heat for fields (nx, ny); returns the power that the walls give.

        StepRejected where a law finds none.
        """
        power = give_heat(self.laws_of_heat, self.gas, density, temperature)
        if math.isnan(power):
            self.refuse_no_heat()
        return power

    def give_slopes(self) -> None:
        """Have the laws find the slopes of the heat that `give_heat` has found."""
        for side in self.heaters.values():
            fill_slopes(side.law, self.gas, side.density, side.temperature, side.half_width, side.rows)

    def refuse_no_heat(self) -> None:
        """StepRejected where a law has found no heat for gas that is as it should be."""
        for name, side in self.heaters.items():
            n, T = side.density, side.temperature
            no_heat = np.isnan(side.rows[HEAT]) & (n > 0.0) & (T > 0.0) & np.isfinite(n * T)
            if no_heat.any():
                j = int(np.argmax(no_heat))
                raise StepRejected(
                    f"the law of the wall {name} finds no heat for n = {n[j]:.4g}, T = {T[j]:.4g} beside it"
                )

    def temperatures(self) -> dict[str, np.ndarray]:
        """Temperatures of the heated sides, first guesses of the next, by name; copies."""
        return {f"wall_temperature_{name}": side.rows[TEMPERATURE].copy() for name, side in self.heaters.items()}

    def take_temperatures(self, memory: dict[str, np.ndarray]) -> None:
        """Take back what `temperatures` gave."""
        for name, side in self.heaters.items():
            side.rows[TEMPERATURE] = memory[f"wall_temperature_{name}"]


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
def give_heat(heaters, gas, density, temperature):
    """Have the laws find their heat for fields (nx, ny); returns the power that the walls give.

    heaters: a tuple of `Heater`, which keep what is beside them. This loop alone is compiled for the laws that are
    there, as a set: it calls the kernel of each.
    """
    power = 0.0
    for side in literal_unroll(heaters):
        for j in range(side.temperature.size):
            i, k = (side.last, j) if side.axis == 0 else (j, side.last)
            side.density[j], side.temperature[j] = density[i, k], temperature[i, k]
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
