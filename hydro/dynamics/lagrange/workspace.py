"""Arrays of one step of the implicit integrator."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydro.mesh import GHOSTS, Faces, Mesh

MASS, ENERGY = 0, 1  # rows of `carried`: what a unit of momentum at the face takes along

# Scratch lines, (ny + 4,). Of faces: momentum, mass, energy and heat; in x below or above the rows that have an even
# number, and those that have an odd one, and in y.
EVEN, ODD, ALONG = 0, 4, 8
MOMENTUM_LINE, MASS_LINE, ENERGY_LINE, HEAT_LINE = 0, 1, 2, 3  # of each of these groups
CELL_MOMENTUM = 12  # of cells, in x and y
WEIGHT, PROFILES, STREAMS, DENSITY_LOW, DENSITY_HIGH, PADDED = 14, 15, 19, 21, 22, 23
LINES = 24


class Work(NamedTuple):
    """Arrays of one step on (nx, ny) cells."""

    ahead: np.ndarray  # (4, nx + 2 GHOSTS, ny), extrapolated n, u, v, p, with the rows beyond the sides in x
    base: np.ndarray  # (4, nx, ny), what the last two states contribute
    stream: np.ndarray  # (2, nx, ny), change of the momentum of cells by what streams in and out
    carried_x: np.ndarray  # (2, nx + 1, ny)
    carried_y: np.ndarray  # (2, nx, ny + 1)
    momentum: Faces  # before pressure acts
    density: np.ndarray  # (nx, ny)
    kappa: np.ndarray  # (nx, ny)
    cooling: np.ndarray  # (nx, ny)
    kappa_slopes: np.ndarray  # (2, nx, ny), in P and in T
    violence: np.ndarray  # (nx, ny), see `shocks`
    shared: np.ndarray  # (1,), whether faces share their momentum by mass
    lines: np.ndarray  # (LINES, ny + 4), scratch

    @classmethod
    def of(cls, mesh: Mesh) -> Work:
        nx, ny = mesh.cells
        return cls(
            np.ones((4, nx + 2 * GHOSTS, ny)), np.zeros((4, nx, ny)), np.zeros((2, nx, ny)), np.zeros((2, nx + 1, ny)),
            np.zeros((2, nx, ny + 1)), Faces.of(mesh), np.zeros((nx, ny)), np.zeros((nx, ny)), np.zeros((nx, ny)),
            np.zeros((2, nx, ny)), np.zeros((nx, ny)), np.zeros(1, bool), np.zeros((LINES, ny + 4)),
        )  # fmt: skip

    def foreseen(self, field: int) -> np.ndarray:
        """An extrapolated field of the cells, (nx, ny)."""
        return self.ahead[field, GHOSTS:-GHOSTS]
