"""Sums over the cells that are joined, and interpolation between those that are not."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydro.dynamics.multigrid.level import Level, groups
from hydro.dynamics.multigrid.stencil import COUPLINGS, DRIFT_PA
from hydro.jit import kernel, part
from hydro.mesh import inverse_distances

ONE, TWO = np.uint64(1), np.uint64(2)


class Transfer(NamedTuple):
    """The way between a level of (nx, ny) cells and the next coarser one."""

    owner_x: np.ndarray  # (nx,), the coarse row that each row belongs to
    first: np.ndarray  # (coarse ny + 1,), the first column of each coarse one, and ny
    ratio_x: np.ndarray  # (nx,), distances between centres, fine over coarse
    ratio_y: np.ndarray  # (ny,)
    low_x: np.ndarray  # (nx,), coarse rows to both sides of every row, and their shares (2, nx)
    high_x: np.ndarray
    shares_x: np.ndarray
    low_y: np.ndarray  # (ny,), and likewise in y
    high_y: np.ndarray
    shares_y: np.ndarray

    @classmethod
    def between(cls, fine: Level, coarse: Level) -> Transfer:
        owners = [np.repeat(np.arange(c), np.diff(groups(f))) for f, c in zip(fine.shape, coarse.shape, strict=True)]
        ratios = []
        for axis in (0, 1):
            near, far = inverse_distances(fine.widths[axis])[:-1], inverse_distances(coarse.widths[axis])[:-1]
            ratios.append((far[owners[axis]] / near).astype(np.float32))
        ratio_x, ratio_y = ratios
        low_x, high_x, shares_x = neighbours(fine, coarse, 0)
        low_y, high_y, shares_y = neighbours(fine, coarse, 1)
        first = groups(fine.shape[1])
        return cls(owners[0], first, ratio_x, ratio_y, low_x, high_x, shares_x, low_y, high_y, shares_y)


def neighbours(fine: Level, coarse: Level, axis: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coarse cells to both sides of every fine centre along an axis, and the shares of the lower and the upper one."""
    widths, count = coarse.widths[axis], coarse.shape[axis]
    centres, fine_centres = (np.cumsum(w) - 0.5 * w for w in (widths, fine.widths[axis]))
    around = np.concatenate([[centres[-1] - widths.sum()], centres, [centres[0] + widths.sum()]])
    high = np.searchsorted(centres, fine_centres)
    shares = np.array([around[high + 1] - fine_centres, fine_centres - around[high]]) / np.diff(around)[high]
    if fine.periodic[axis]:
        return (high - 1) % count, high % count, shares.astype(np.float32)
    shares[:, high == 0], shares[:, high == count] = [[0.0], [1.0]], [[1.0], [0.0]]
    return np.maximum(high - 1, 0), np.minimum(high, count - 1), shares.astype(np.float32)


@part(exact=True)
def blend_row(below, above, under, over, out):
    """A row between two coarse ones, with ghost columns."""
    for j in range(np.uint64(below.size)):
        out[j] = under * below[j] + over * above[j]


@part(exact=True)
def interpolate_row(here, coarse, low, high, shares, out):
    """out = here + the interpolated coarse row; all with ghost columns."""
    under, over = shares[0], shares[1]
    for j in range(np.uint64(under.size)):
        out[j + ONE] = here[j + ONE] + (under[j] * coarse[low[j] + 1] + over[j] * coarse[high[j] + 1])


@kernel(exact=True)
def add_up(fine, owner_x, first, coarse):
    """Sums over the cells that are joined; (nx, fields, ny)."""
    coarse[:] = 0.0
    for i in range(fine.shape[0]):
        for field in range(fine.shape[1]):
            join_row(fine[i, field], first, coarse[owner_x[i], field])


@part(exact=True)
def join_row(fine, first, coarse):
    """Add a row of cells, joined, to a coarse one; mirror images have mirror images of sums."""
    count = np.uint64(coarse.size)
    if fine.size == coarse.size:
        for m in range(count):
            coarse[m] += fine[m]
    elif fine.size == 2 * coarse.size:
        for m in range(count):
            coarse[m] += fine[TWO * m] + fine[TWO * m + ONE]
    else:
        for m in range(coarse.size):
            low, high = first[m], first[m + 1] - 1
            outer = fine[low] + fine[high] if high > low else fine[low]
            coarse[m] += outer + fine[low + 1] if high > low + 1 else outer


@kernel(exact=True)
def add_faces_x(fine, owner_x, first, ratio, coarse):
    """Sums over the faces in x that stay between cells which are not joined; differences span longer distances."""
    coarse[:] = 0.0
    for i in range(fine.shape[0]):
        if i == 0 or owner_x[i - 1] != owner_x[i]:
            for field in range(COUPLINGS):
                out = coarse[owner_x[i], field]
                join_row(fine[i, field], first, out)
                if field < DRIFT_PA:
                    for m in range(np.uint64(out.size)):
                        out[m] *= ratio[i]


@kernel(exact=True)
def add_faces_y(fine, owner_x, first, ratio, coarse):
    """The same for the faces in y, each between two columns of cells."""
    coarse[:] = 0.0
    for i in range(fine.shape[0]):
        for field in range(COUPLINGS):
            longer = field < DRIFT_PA
            pick_row(fine[i, field], first, ratio, longer, coarse[owner_x[i], field])


@part(exact=True)
def pick_row(fine, first, ratio, longer, coarse):
    """Add to a coarse row the faces that stay of a fine one: those below the first cells that are joined."""
    for m in range(np.uint64(coarse.size)):
        j = np.uint64(first[m])
        coarse[m] += fine[j] * (ratio[j] if longer else np.float32(1.0))
