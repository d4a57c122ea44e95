"""Sums over the cells that are joined, and interpolation between those that are not."""

from __future__ import annotations

import numpy as np

from hydro.dynamics.multigrid.stencil import COUPLINGS, DRIFT_PA
from hydro.jit import kernel, part

ONE, TWO = np.uint64(1), np.uint64(2)


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
            pick_row(fine[i, field], first, ratio, field < DRIFT_PA, coarse[owner_x[i], field])


@part(exact=True)
def pick_row(fine, first, ratio, longer, coarse):
    """Add to a coarse row the faces that stay of a fine one: those below the first cells that are joined."""
    for m in range(np.uint64(coarse.size)):
        j = np.uint64(first[m])
        coarse[m] += fine[j] * (ratio[j] if longer else np.float32(1.0))
