"""Equations of a level: couplings across faces, stencils of cells, and their residuals."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydro.jit import kernel, part

# What crosses a face, per unit of the unknowns; fields of arrays (nx, COUPLINGS, ny), face [i, j] below cell [i, j].
MASS, ENERGY_P, ENERGY_T = 0, 1, 2  # by differences: M, H, C
DRIFT_PA, DRIFT_PB, DRIFT_TA, DRIFT_TB = 3, 4, 5, 6
COUPLINGS = 7

# Fields of the stencil of a cell: its own block, inverse of that, and neighbours.
D11, D12, D21, D22, V11, V12, V21, V22 = range(8)
XL_P, XL_T, XH_P, XH_T, YL_P, YL_T, YH_P, YH_T = range(8, 16)
STENCIL = 16

ONE = np.uint64(1)


class Equations(NamedTuple):
    """The equations of a level of (nx, ny) cells."""

    local: np.ndarray  # (nx, 4, ny)
    faces_x: np.ndarray  # (nx, COUPLINGS, ny)
    faces_y: np.ndarray  # (nx, COUPLINGS, ny)
    stencil: np.ndarray  # (nx, STENCIL, ny), which `build` makes of the others
    periodic_y: bool

    @classmethod
    def of(cls, nx: int, ny: int, periodic_y: bool) -> Equations:
        shapes = ((nx, count, ny) for count in (4, COUPLINGS, COUPLINGS, STENCIL))
        local, faces_x, faces_y, stencil = (np.zeros(shape, np.float32) for shape in shapes)
        return cls(local, faces_x, faces_y, stencil, periodic_y)


class Stencils(NamedTuple):
    """What residuals ask of the equations of a level."""

    stencil: np.ndarray
    faces_x: np.ndarray
    faces_y: np.ndarray
    periodic_y: bool


@kernel(exact=True)
def build(equations):
    """Stencils from local terms and couplings."""
    for i in range(equations.local.shape[0]):
        build_row(equations, i)


@part(exact=True)
def build_row(equations, i):
    """Row i of them."""
    local, stencil = equations.local, equations.stencil
    for q in range(4):
        for j in range(local.shape[2]):
            stencil[i, D11 + q, j] = local[i, q, j]
    couple_row(equations.faces_x, i, (i + 1) % local.shape[0], stencil)
    couple_line(equations.faces_y, i, stencil)
    invert_row(stencil, i)


@part(exact=True)
def couple_row(faces, i, k, stencil):
    """Couplings in x of row i; row k is the next."""
    d11, d21, d22 = stencil[i, D11], stencil[i, D21], stencil[i, D22]
    below_p, below_t, above_p, above_t = stencil[i, XL_P], stencil[i, XL_T], stencil[i, XH_P], stencil[i, XH_T]
    mass_l, p_l, t_l = faces[i, MASS], faces[i, ENERGY_P], faces[i, ENERGY_T]
    mass_h, p_h, t_h = faces[k, MASS], faces[k, ENERGY_P], faces[k, ENERGY_T]
    pa_l, pb_l, ta_l, tb_l = faces[i, DRIFT_PA], faces[i, DRIFT_PB], faces[i, DRIFT_TA], faces[i, DRIFT_TB]
    pa_h, pb_h, ta_h, tb_h = faces[k, DRIFT_PA], faces[k, DRIFT_PB], faces[k, DRIFT_TA], faces[k, DRIFT_TB]
    for j in range(np.uint64(d11.size)):
        d11[j] += mass_l[j] + mass_h[j]
        d21[j] += (p_l[j] + pb_l[j]) + (p_h[j] - pa_h[j])
        d22[j] += (t_l[j] + tb_l[j]) + (t_h[j] - ta_h[j])
        below_p[j], below_t[j] = pa_l[j] - p_l[j], ta_l[j] - t_l[j]
        above_p[j], above_t[j] = -pb_h[j] - p_h[j], -tb_h[j] - t_h[j]


@part(exact=True)
def couple_line(faces, i, stencil):
    """Couplings in y of row i."""
    d11, d21, d22 = stencil[i, D11], stencil[i, D21], stencil[i, D22]
    below_p, below_t, above_p, above_t = stencil[i, YL_P], stencil[i, YL_T], stencil[i, YH_P], stencil[i, YH_T]
    mass, p, t = faces[i, MASS], faces[i, ENERGY_P], faces[i, ENERGY_T]
    pa, pb, ta, tb = faces[i, DRIFT_PA], faces[i, DRIFT_PB], faces[i, DRIFT_TA], faces[i, DRIFT_TB]
    last = np.uint64(d11.size) - ONE
    for j in range(last + ONE):
        k = j + ONE if j < last else j - last
        d11[j] += mass[j] + mass[k]
        d21[j] += (p[j] + pb[j]) + (p[k] - pa[k])
        d22[j] += (t[j] + tb[j]) + (t[k] - ta[k])
        below_p[j], below_t[j] = pa[j] - p[j], ta[j] - t[j]
        above_p[j], above_t[j] = -pb[k] - p[k], -tb[k] - t[k]


@part(exact=True)
def invert_row(stencil, i):
    """Inverses of the blocks of row i."""
    d11, d12, d21, d22 = stencil[i, D11], stencil[i, D12], stencil[i, D21], stencil[i, D22]
    v11, v12, v21, v22 = stencil[i, V11], stencil[i, V12], stencil[i, V21], stencil[i, V22]
    for j in range(np.uint64(d11.size)):
        over = np.float32(1.0) / (d11[j] * d22[j] - d12[j] * d21[j])
        v11[j], v12[j], v21[j], v22[j] = d22[j] * over, -d12[j] * over, -d21[j] * over, d11[j] * over


@part(exact=True)
def residual_row(equations, i, behind, here, ahead, right, out):
    """Residuals (2, ny) of row i from the unknowns (2, ny + 2) of three rows."""
    s, faces_x, along = equations.stencil[i], equations.faces_x, equations.faces_y[i, MASS]
    low, high = faces_x[i, MASS], faces_x[(i + 1) % faces_x.shape[0], MASS]
    d11, d12, d21, d22 = s[D11], s[D12], s[D21], s[D22]
    xl_p, xl_t, xh_p, xh_t = s[XL_P], s[XL_T], s[XH_P], s[XH_T]
    yl_p, yl_t, yh_p, yh_t = s[YL_P], s[YL_T], s[YH_P], s[YH_T]
    p_behind, t_behind, p, t, p_ahead, t_ahead = behind[0], behind[1], here[0], here[1], ahead[0], ahead[1]
    right_1, right_2, out_1, out_2 = right[0], right[1], out[0], out[1]
    last = np.uint64(d11.size) - ONE
    for j in range(last + ONE):
        k = j + ONE
        above = along[j + ONE] if j < last else along[0]
        in_x = low[j] * p_behind[k] + high[j] * p_ahead[k]
        in_y = along[j] * p[j] + above * p[k + ONE]
        out_1[j] = right_1[j] - d11[j] * p[k] - d12[j] * t[k] + (in_x + in_y)
        in_x = (xl_p[j] * p_behind[k] + xl_t[j] * t_behind[k]) + (xh_p[j] * p_ahead[k] + xh_t[j] * t_ahead[k])
        in_y = (yl_p[j] * p[j] + yl_t[j] * t[j]) + (yh_p[j] * p[k + ONE] + yh_t[j] * t[k + ONE])
        out_2[j] = right_2[j] - d21[j] * p[k] - d22[j] * t[k] - (in_x + in_y)
