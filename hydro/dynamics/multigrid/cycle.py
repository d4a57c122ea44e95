"""Smoothing, and the way between a level and the next in one passage over the rows."""

from __future__ import annotations

import numpy as np

from hydro.dynamics.multigrid.level import CORRECTED, REST, SWEPT, ZERO
from hydro.dynamics.multigrid.stencil import V11, V12, V21, V22, Stencils, residual_row
from hydro.dynamics.multigrid.transfer import blend_row, interpolate_row, join_row
from hydro.jit import kernel, part

ONE = np.uint64(1)


@part(exact=True)
def wrap_row(row, periodic):
    """Ghost columns: across a periodic side. At walls nothing looks at them."""
    if periodic:
        row[0], row[-1] = row[-2], row[1]


@part(exact=True)
def relax_row(equations, i, rest, here, weight, out):
    """out = here + weight times inverse blocks times residuals, in row i, with its ghost columns."""
    s = equations.stencil[i]
    v11, v12, v21, v22, r_1, r_2 = s[V11], s[V12], s[V21], s[V22], rest[0], rest[1]
    p, t, p_new, t_new = here[0], here[1], out[0], out[1]
    for j in range(np.uint64(v11.size)):
        k = j + ONE
        p_new[k] = p[k] + weight * (v11[j] * r_1[j] + v12[j] * r_2[j])
        t_new[k] = t[k] + weight * (v21[j] * r_1[j] + v22[j] * r_2[j])
    wrap_row(p_new, equations.periodic_y)
    wrap_row(t_new, equations.periodic_y)


@kernel(exact=True)
def descend(
    weights, stencil, faces_x, faces_y, periodic_y, owner_x, first, right, unknowns, from_zero, lines, out, coarse
):  # fmt: skip
    """Two sweeps from `unknowns`, or from zero, into `out`; the residuals that stay, summed, into `coarse`.

    It takes arrays one by one: handing over groups of them took 2 microseconds more, a third of a call on the coarse
    levels, of which a cycle has dozens.

    All in one passage over the rows, so that memory is read once: the second sweep follows one row behind the first,
    the residuals one row behind that. Where x is periodic, rows come again at both ends.
    """
    nx, rest = right.shape[0], lines[REST]
    equations = Stencils(stencil, faces_x, faces_y, periodic_y)
    coarse[:] = 0.0
    for k in range(-2, nx + 2):
        i, new = k % nx, lines[SWEPT + k % 3]
        if k <= nx and from_zero:
            relax_row(equations, i, right[i], lines[ZERO], weights[0], new)
        elif k <= nx:
            behind, ahead = unknowns[(i - 1) % nx], unknowns[(i + 1) % nx]
            residual_row(equations, i, behind, unknowns[i], ahead, right[i], rest)
            relax_row(equations, i, rest, unknowns[i], weights[0], new)
        if 0 <= k <= nx:
            sweep(weights[1], equations, right, lines, SWEPT, k - 1, out[(k - 1) % nx])
        if k >= 2:
            i = k - 2
            residual_row(equations, i, out[(i - 1) % nx], out[i], out[(i + 1) % nx], right[i], rest)
            for field in range(2):
                join_row(rest[field, : right.shape[2]], first, coarse[owner_x[i], field])


@part(exact=True)
def sweep(weight, equations, right, lines, start, k, out):
    """Row k of a sweep from the rows that `lines` hold from `start` on, each at its number modulo three."""
    i, rest, here = k % right.shape[0], lines[REST], lines[start + k % 3]
    behind, ahead = lines[start + (k - 1) % 3], lines[start + (k + 1) % 3]
    residual_row(equations, i, behind, here, ahead, right[i], rest)
    relax_row(equations, i, rest, here, weight, out)


@kernel(exact=True)
def ascend(
    weights, stencil, faces_x, faces_y, periodic_y, low_x, high_x, shares_x, low_y, high_y, shares_y, right, unknowns,
    coarse, lines, out,
):  # fmt: skip
    """Two sweeps from `unknowns` and the interpolated `coarse` ones into `out`, in one passage as in `descend`."""
    nx, shares = right.shape[0], shares_x
    equations = Stencils(stencil, faces_x, faces_y, periodic_y)
    for k in range(-2, nx + 2):
        i, new = k % nx, lines[CORRECTED + k % 3]
        below, above = coarse[low_x[i]], coarse[high_x[i]]
        for field in range(2):
            blend_row(below[field], above[field], shares[0, i], shares[1, i], lines[REST, field])
            interpolate_row(unknowns[i, field], lines[REST, field], low_y, high_y, shares_y, new[field])
            wrap_row(new[field], equations.periodic_y)
        if k >= 0:
            new = lines[SWEPT + (k - 1) % 3]
            sweep(weights[0], equations, right, lines, CORRECTED, k - 1, new)
        if k >= 2:
            sweep(weights[1], equations, right, lines, SWEPT, k - 2, out[k - 2])
