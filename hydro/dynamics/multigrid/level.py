"""One mesh of the hierarchy, and how cells are joined to the next."""

from __future__ import annotations

import numpy as np

from hydro.dynamics.multigrid.stencil import Equations

# Scratch lines of a level, (2, ny + 2): residuals, zeros, and three rows each of unknowns that follow one another.
REST, ZERO, SWEPT, CORRECTED = 0, 1, 2, 5
LINES = 8

COARSEST = 3  # cells along a side


class Level:
    """One mesh of the hierarchy, with its equations, right-hand side and unknowns.

    The fields of a row of cells lie side by side: apart by a power of two, they would share few places of the cache.
    """

    def __init__(self, widths: tuple[np.ndarray, np.ndarray], periodic: tuple[bool, bool]):
        self.widths, self.periodic = widths, periodic
        nx, ny = self.shape = widths[0].size, widths[1].size
        self.equations = Equations.of(nx, ny, periodic[1])
        self.right = np.zeros((nx, 2, ny), np.float32)
        self.unknowns = np.zeros((nx, 2, ny + 2), np.float32)  # with a ghost column on both sides
        self.spare = np.zeros_like(self.unknowns)  # where new ones are written
        self.lines = np.zeros((LINES, 2, ny + 2), np.float32)  # scratch

    def coarser(self) -> Level:
        """The level with pairs of cells joined, along every side that has more than COARSEST."""
        return Level((joined(self.widths[0]), joined(self.widths[1])), self.periodic)


def groups(count: int) -> np.ndarray:
    """The first cells of what becomes one on the coarser level, and `count`: pairs; of an odd number, the cell in the
    middle stays single, or three in the middle join, so that mirror images stay so; few cells stay as they are.
    """
    if count <= COARSEST:
        return np.arange(count + 1)
    if count % 2 == 0:
        return np.arange(0, count + 1, 2)
    pairs = 2 * np.arange(count // 4 + 1)
    return np.concatenate([pairs, count - pairs[::-1]])


def joined(widths: np.ndarray) -> np.ndarray:
    """Widths of cells joined as `groups` says."""
    return np.add.reduceat(widths, groups(widths.size)[:-1])
