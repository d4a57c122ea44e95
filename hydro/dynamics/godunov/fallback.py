"""What keeps cells admissible where the second-order update does not: they fall back to first-order fluxes.

All faces of such a cell have the flux of `hydro.dynamics.riemann.Positive` between the averages of the two cells beside
them. Both cells see the same flux, so that books close. The update of the cell is then a mean of its own state and of
the states behind the waves of its faces, all of them admissible, as long as

    dt (inward speed)/(width) added up over its four faces is one or less:

the step is halved where that is not so. A cell beside it, which has second-order fluxes on its other faces, may become
inadmissible by that, and then falls back, too. Stresses spare the cells that they would leave inadmissible.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from hydro.mesh import Mesh
from hydro.state import State, inadmissible

MOST_ROUNDS = 20  # of cells that follow their neighbours, in one step


class Fallen(NamedTuple):
    """Cells that have fallen back, with a line of cells beyond each side: images at periodic sides, none at walls."""

    cells: np.ndarray  # (nx + 2, ny + 2), whether a cell has
    rows: np.ndarray  # (nx + 2,), whether one in a row has

    @classmethod
    def none(cls, mesh: Mesh) -> Fallen:
        nx, ny = mesh.cells
        return cls(np.zeros((nx + 2, ny + 2), bool), np.zeros(nx + 2, bool))

    def let(self, cells: np.ndarray, periodic: tuple[bool, bool]) -> None:
        """Have the cells, (nx, ny), and no others, fall back."""
        for axis, wraps in enumerate(periodic):
            width = [(1, 1) if k == axis else (0, 0) for k in range(2)]
            cells = np.pad(cells, width, mode="wrap") if wraps else np.pad(cells, width)
        self.cells[:] = cells
        self.rows[:] = cells.any(axis=1)


def careful(update: Callable[[np.ndarray], None], result: State) -> int:
    """Call `update(cells)` with no cells, and again with those that `result` is inadmissible in, until that helps.

    cells: (nx, ny), what the update has to take care of; a cell stays among them. Returns their number.
    """
    cells = np.zeros(result.mesh.cells, bool)
    update(cells)
    for _ in range(MOST_ROUNDS):
        further = inadmissible(result) & ~cells
        if not further.any():
            break
        cells |= further
        update(cells)
    return int(cells.sum())
