"""All levels, and the cycle through them."""

from __future__ import annotations

import numpy as np

from hydro.dynamics.multigrid.cycle import ascend, descend, wrap_row
from hydro.dynamics.multigrid.level import COARSEST, Level
from hydro.dynamics.multigrid.stencil import build, residual_row
from hydro.dynamics.multigrid.transfer import Transfer, add_faces_x, add_faces_y, add_up
from hydro.jit import kernel
from hydro.mesh import Mesh

CHEBYSHEV = np.array([0.5620, 1.3885], np.float32)  # weights that damp eigenvalues in [1/2, 2] by 4.6, the best of two


class Hierarchy:
    """All levels, the finest first. Fill the `equations` of the finest, then call `prepare`."""

    def __init__(self, mesh: Mesh):
        self.levels = [Level((mesh.dx, mesh.dy), mesh.periodic)]
        while max(self.levels[-1].shape) > COARSEST:
            self.levels.append(self.levels[-1].coarser())
        self._steps = [Step(*pair) for pair in zip(self.levels, self.levels[1:], strict=False)]
        self._inverse = np.zeros((1, 1))

    def prepare(self) -> None:
        """The coarser levels from the finest."""
        for step in self._steps:
            step.couple()
        self._inverse = np.linalg.inv(dense(self.levels[-1]))

    def cycle(self) -> None:
        """One cycle, from zero, for the `right` of the finest level; the result is in its `unknowns`."""
        self._cycle(0, from_zero=True, again=True)

    def _cycle(self, number: int, from_zero: bool, again: bool) -> None:
        """An F-cycle from a level down, if coarser ones are to be visited `again`, else a V-cycle.

        The second level is visited once: it costs a quarter of the finest, and the next ones do what is needed.
        """
        if number == len(self._steps):
            self._solve_coarsest()
            return
        step = self._steps[number]
        step.descend(from_zero)
        self._cycle(number + 1, from_zero=True, again=again)
        if again and number > 0:
            self._cycle(number + 1, from_zero=False, again=False)
        step.ascend()

    def _solve_coarsest(self) -> None:
        coarsest = self.levels[-1]
        solution = (self._inverse @ coarsest.right.reshape(-1)).reshape(coarsest.right.shape)
        coarsest.unknowns[:, :, 1:-1] = solution
        if coarsest.periodic[1]:
            coarsest.unknowns[:, :, [0, -1]] = solution[:, :, [-1, 0]]


class Step:
    """The way between a level and the next coarser one."""

    def __init__(self, fine: Level, coarse: Level):
        self.fine, self.coarse, self._transfer = fine, coarse, Transfer.between(fine, coarse)
        equations, way = fine.equations, self._transfer
        matrix = (CHEBYSHEV, equations.stencil, equations.faces_x, equations.faces_y, equations.periodic_y)
        self._down = (*matrix, way.owner_x, way.first)
        self._up = (*matrix, way.low_x, way.high_x, way.shares_x, way.low_y, way.high_y, way.shares_y)

    def couple(self) -> None:
        """The equations of the coarse level."""
        fine, coarse, way = self.fine.equations, self.coarse.equations, self._transfer
        add_up(fine.local, way.owner_x, way.first, coarse.local)
        add_faces_x(fine.faces_x, way.owner_x, way.first, way.ratio_x, coarse.faces_x)
        add_faces_y(fine.faces_y, way.owner_x, way.first, way.ratio_y, coarse.faces_y)
        build(coarse)

    def descend(self, from_zero: bool) -> None:
        """Smooth the fine unknowns, or zero; the residuals that stay, summed, become the coarse right-hand side."""
        fine = self.fine
        descend(
            *self._down, fine.right, fine.unknowns, from_zero, fine.lines, fine.spare, self.coarse.right,
        )  # fmt: skip
        fine.unknowns, fine.spare = fine.spare, fine.unknowns

    def ascend(self) -> None:
        """Add the coarse correction, interpolated, and smooth."""
        fine = self.fine
        ascend(*self._up, fine.right, fine.unknowns, self.coarse.unknowns, fine.lines, fine.spare)
        fine.unknowns, fine.spare = fine.spare, fine.unknowns


def dense(level: Level) -> np.ndarray:
    """The matrix of a level, (2 nx ny, 2 nx ny), column by column."""
    matrix = np.empty((level.right.size, level.right.size))
    unit, out = np.zeros_like(level.unknowns), np.zeros_like(level.right)
    zero = np.zeros_like(level.right)
    columns(level.equations, zero, unit, out, matrix)
    return matrix


@kernel(exact=True)
def columns(equations, zero, unit, out, matrix):
    """What the matrix makes of every unit vector."""
    nx, fields, ny = zero.shape
    for k in range(matrix.shape[0]):
        row = unit[k // (fields * ny), k // ny % fields]
        row[k % ny + 1] = 1.0
        wrap_row(row, equations.periodic_y)
        for i in range(nx):
            residual_row(equations, i, unit[i - 1], unit[i], unit[(i + 1) % nx], zero[i], out[i])
            for field in range(fields):
                for j in range(ny):
                    matrix[(i * fields + field) * ny + j, k] = -out[i, field, j]
        row[:] = 0.0
