"""Multigrid for pairs of unknowns per cell, pressure and temperature, coupled to the four neighbours.

Rows are the balances of mass and of energy of a cell. What crosses a face, from a lower cell a to an upper one b, is

    mass:    M (P_b - P_a)
    energy:  H (P_b - P_a) + C (T_b - T_a) + drift,    drift = A_P P_a + B_P P_b + A_T T_a + B_T T_b;

it is added to the rows of b and taken from those of a. Coarser levels join two by two cells: local terms and drifts
add up, and so do M, H and C, times the ratio of the distances between centres. On every level a cycle smooths by two
block Jacobi sweeps with Chebyshev weights before and after the coarser ones (they treat mirror images alike, which
Gauss-Seidel does not), sums residuals up and interpolates corrections bilinearly; the coarsest level is solved
directly. From the second level down it is an F-cycle: coarser levels are visited again, by a V-cycle, for what the
first visit has left.

The cycle works in single precision: it improves a solution whose residuals are double. Its arithmetic is exact, in the
order written, in which mirror images in y are treated alike to the last bit.
"""

from __future__ import annotations

import numpy as np

from hydro.jit import kernel, part
from hydro.mesh import Mesh, inverse_distances

# What crosses a face, per unit of the unknowns; fields of arrays (nx, COUPLINGS, ny), face [i, j] below cell [i, j].
MASS, ENERGY_P, ENERGY_T = 0, 1, 2  # by differences: M, H, C
DRIFT_PA, DRIFT_PB, DRIFT_TA, DRIFT_TB = 3, 4, 5, 6
COUPLINGS = 7

# Fields of the stencil of a cell: its own block, inverse of that, and neighbours.
D11, D12, D21, D22, V11, V12, V21, V22 = range(8)
XL_P, XL_T, XH_P, XH_T, YL_P, YL_T, YH_P, YH_T = range(8, 16)
STENCIL = 16

# Scratch lines of a level, (2, ny + 2): residuals, zeros, and three rows each of unknowns that follow one another.
REST, ZERO, SWEPT, CORRECTED = 0, 1, 2, 5
LINES = 8

COARSEST = 3  # cells along a side
CHEBYSHEV = np.array([0.5620, 1.3885], np.float32)  # weights that damp eigenvalues in [1/2, 2] by 4.6, the best of two
ONE, TWO = np.uint64(1), np.uint64(2)


class Level:
    """One mesh of the hierarchy, with its equations, right-hand side and unknowns.

    The fields of a row of cells lie side by side: apart by a power of two, they would share few places of the cache.
    """

    def __init__(self, widths: tuple[np.ndarray, np.ndarray], periodic: tuple[bool, bool]):
        self.widths, self.periodic = widths, periodic
        nx, ny = self.shape = widths[0].size, widths[1].size
        self.local = np.zeros((nx, 4, ny), np.float32)
        self.faces_x = np.zeros((nx, COUPLINGS, ny), np.float32)
        self.faces_y = np.zeros((nx, COUPLINGS, ny), np.float32)
        self.stencil = np.zeros((nx, STENCIL, ny), np.float32)
        self.right = np.zeros((nx, 2, ny), np.float32)
        self.unknowns = np.zeros((nx, 2, ny + 2), np.float32)  # with a ghost column on both sides
        self.spare = np.zeros_like(self.unknowns)  # where new ones are written
        self.lines = np.zeros((LINES, 2, ny + 2), np.float32)  # scratch

    def equations(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Local terms, couplings in x and in y, and the stencils that `build` makes of them."""
        return self.local, self.faces_x, self.faces_y, self.stencil

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
        self.fine, self.coarse = fine, coarse
        self._first = groups(fine.shape[1])
        owners = [np.repeat(np.arange(c), np.diff(groups(f))) for f, c in zip(fine.shape, coarse.shape, strict=True)]
        self._owner_x = owners[0]  # the coarse row that each row belongs to
        ratios = []
        for axis in (0, 1):
            near, far = inverse_distances(fine.widths[axis])[:-1], inverse_distances(coarse.widths[axis])[:-1]
            ratios.append((far[owners[axis]] / near).astype(np.float32))
        self._ratio_x, self._ratio_y = ratios
        self._low, self._high, self._shares = neighbours(fine, coarse, 1)
        self._low_x, self._high_x, self._shares_x = neighbours(fine, coarse, 0)

    def couple(self) -> None:
        """The equations of the coarse level."""
        fine, coarse = self.fine, self.coarse
        add_up(fine.local, self._owner_x, self._first, coarse.local)
        add_faces_x(fine.faces_x, self._owner_x, self._first, self._ratio_x, coarse.faces_x)
        add_faces_y(fine.faces_y, self._owner_x, self._first, self._ratio_y, coarse.faces_y)
        build(*coarse.equations())

    def descend(self, from_zero: bool) -> None:
        """Smooth the fine unknowns, or zero; the residuals that stay, summed, become the coarse right-hand side."""
        fine, coarse = self.fine, self.coarse
        descend(
            CHEBYSHEV, fine.stencil, fine.faces_x, fine.faces_y, fine.periodic[1], fine.right, fine.unknowns, from_zero,
            fine.lines, fine.spare, self._owner_x, self._first, coarse.right,
        )  # fmt: skip
        fine.unknowns, fine.spare = fine.spare, fine.unknowns

    def ascend(self) -> None:
        """Add the coarse correction, interpolated, and smooth."""
        fine, coarse = self.fine, self.coarse
        ascend(
            CHEBYSHEV, fine.stencil, fine.faces_x, fine.faces_y, fine.periodic[1], fine.right, fine.unknowns,
            coarse.unknowns, self._low_x, self._high_x, self._shares_x, self._low, self._high, self._shares,
            fine.lines, fine.spare,
        )  # fmt: skip
        fine.unknowns, fine.spare = fine.spare, fine.unknowns


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


def dense(level: Level) -> np.ndarray:
    """The matrix of a level, (2 nx ny, 2 nx ny), column by column."""
    matrix = np.empty((level.right.size, level.right.size))
    unit, out = np.zeros_like(level.unknowns), np.zeros_like(level.right)
    zero = np.zeros_like(level.right)
    columns(level.stencil, level.faces_x, level.faces_y, level.periodic[1], zero, unit, out, matrix)
    return matrix


@kernel(exact=True)
def columns(stencil, faces_x, faces_y, periodic, zero, unit, out, matrix):
    """What the matrix makes of every unit vector."""
    nx, fields, ny = zero.shape
    for k in range(matrix.shape[0]):
        row = unit[k // (fields * ny), k // ny % fields]
        row[k % ny + 1] = 1.0
        wrap_row(row, periodic)
        for i in range(nx):
            residual_row(stencil, faces_x, faces_y, i, unit[i - 1], unit[i], unit[(i + 1) % nx], zero[i], out[i])
            for field in range(fields):
                for j in range(ny):
                    matrix[(i * fields + field) * ny + j, k] = -out[i, field, j]
        row[:] = 0.0


@part(exact=True)
def wrap_row(row, periodic):
    """Ghost columns: across a periodic side. At walls nothing looks at them."""
    if periodic:
        row[0], row[-1] = row[-2], row[1]


@kernel(exact=True)
def build(local, faces_x, faces_y, stencil):
    """Stencils from local terms (nx, 4, ny) and couplings (nx, COUPLINGS, ny)."""
    for i in range(local.shape[0]):
        build_row(local, faces_x, faces_y, i, stencil)


@part(exact=True)
def build_row(local, faces_x, faces_y, i, stencil):
    """Row i of them."""
    for q in range(4):
        for j in range(local.shape[2]):
            stencil[i, D11 + q, j] = local[i, q, j]
    couple_row(faces_x, i, (i + 1) % local.shape[0], stencil)
    couple_line(faces_y, i, stencil)
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
def residual_row(stencil, faces_x, faces_y, i, behind, here, ahead, right, out):
    """Residuals (2, ny) of row i from the unknowns (2, ny + 2) of three rows."""
    residual_line(
        stencil[i, D11], stencil[i, D12], stencil[i, D21], stencil[i, D22],
        stencil[i, XL_P], stencil[i, XL_T], stencil[i, XH_P], stencil[i, XH_T],
        stencil[i, YL_P], stencil[i, YL_T], stencil[i, YH_P], stencil[i, YH_T],
        faces_x[i, MASS], faces_x[(i + 1) % stencil.shape[0], MASS], faces_y[i, MASS],
        behind[0], behind[1], here[0], here[1], ahead[0], ahead[1], right[0], right[1], out[0], out[1],
    )  # fmt: skip


@part(exact=True)
def residual_line(
    d11, d12, d21, d22, xl_p, xl_t, xh_p, xh_t, yl_p, yl_t, yh_p, yh_t, mass_low, mass_high, mass_y,
    p_behind, t_behind, p, t, p_ahead, t_ahead, right_1, right_2, out_1, out_2,
):  # fmt: skip
    """The same with every field by its name."""
    count = np.uint64(d11.size)
    last = count - ONE
    for j in range(count):
        k = j + ONE
        mass_above = mass_y[j + ONE] if j < last else mass_y[0]
        across = mass_low[j] * p_behind[k] + mass_high[j] * p_ahead[k]
        along = mass_y[j] * p[j] + mass_above * p[k + ONE]
        out_1[j] = right_1[j] - d11[j] * p[k] - d12[j] * t[k] + (across + along)
        across = (xl_p[j] * p_behind[k] + xl_t[j] * t_behind[k]) + (xh_p[j] * p_ahead[k] + xh_t[j] * t_ahead[k])
        along = (yl_p[j] * p[j] + yl_t[j] * t[j]) + (yh_p[j] * p[k + ONE] + yh_t[j] * t[k + ONE])
        out_2[j] = right_2[j] - d21[j] * p[k] - d22[j] * t[k] - (across + along)


@part(exact=True)
def relax_row(stencil, i, rest, here, weight, periodic, out):
    """out = here + weight times inverse blocks times residuals, in row i, with its ghost columns."""
    relax_line(
        stencil[i, V11], stencil[i, V12], stencil[i, V21], stencil[i, V22], rest[0], rest[1], weight, here[0], here[1],
        out[0], out[1],
    )  # fmt: skip
    wrap_row(out[0], periodic)
    wrap_row(out[1], periodic)


@part(exact=True)
def relax_line(v11, v12, v21, v22, r_1, r_2, weight, p, t, p_new, t_new):
    """The same with every field by its name."""
    for j in range(np.uint64(v11.size)):
        k = j + ONE
        p_new[k] = p[k] + weight * (v11[j] * r_1[j] + v12[j] * r_2[j])
        t_new[k] = t[k] + weight * (v21[j] * r_1[j] + v22[j] * r_2[j])


@kernel(exact=True)
def descend(
    weights, stencil, faces_x, faces_y, periodic, right, unknowns, from_zero, lines, out, owner_x, first, coarse
):  # fmt: skip
    """Two sweeps from `unknowns`, or from zero, into `out`; the residuals that stay, summed, into `coarse`.

    All in one passage over the rows, so that memory is read once: the second sweep follows one row behind the first,
    the residuals one row behind that. Where x is periodic, rows come again at both ends.
    """
    nx, rest = right.shape[0], lines[REST]
    coarse[:] = 0.0
    for k in range(-2, nx + 2):
        i, new = k % nx, lines[SWEPT + k % 3]
        if k <= nx and from_zero:
            relax_row(stencil, i, right[i], lines[ZERO], weights[0], periodic, new)
        elif k <= nx:
            behind, ahead = unknowns[(i - 1) % nx], unknowns[(i + 1) % nx]
            residual_row(stencil, faces_x, faces_y, i, behind, unknowns[i], ahead, right[i], rest)
            relax_row(stencil, i, rest, unknowns[i], weights[0], periodic, new)
        if 0 <= k <= nx:
            sweep(weights[1], stencil, faces_x, faces_y, periodic, right, lines, SWEPT, k - 1, out[(k - 1) % nx])
        if k >= 2:
            i = k - 2
            residual_row(stencil, faces_x, faces_y, i, out[(i - 1) % nx], out[i], out[(i + 1) % nx], right[i], rest)
            for field in range(2):
                join_row(rest[field, : right.shape[2]], first, coarse[owner_x[i], field])


@part(exact=True)
def sweep(weight, stencil, faces_x, faces_y, periodic, right, lines, start, k, out):
    """Row k of a sweep from the rows that `lines` hold from `start` on, each at its number modulo three."""
    i, rest, here = k % right.shape[0], lines[REST], lines[start + k % 3]
    behind, ahead = lines[start + (k - 1) % 3], lines[start + (k + 1) % 3]
    residual_row(stencil, faces_x, faces_y, i, behind, here, ahead, right[i], rest)
    relax_row(stencil, i, rest, here, weight, periodic, out)


@kernel(exact=True)
def ascend(
    weights, stencil, faces_x, faces_y, periodic, right, unknowns, coarse, low_x, high_x, shares_x, low_y, high_y,
    shares_y, lines, out,
):  # fmt: skip
    """Two sweeps from `unknowns` and the interpolated `coarse` ones into `out`, in one passage as in `descend`."""
    nx = right.shape[0]
    for k in range(-2, nx + 2):
        i, new = k % nx, lines[CORRECTED + k % 3]
        below, above = coarse[low_x[i]], coarse[high_x[i]]
        for field in range(2):
            blend_row(below[field], above[field], shares_x[0, i], shares_x[1, i], lines[REST, field])
            interpolate_row(unknowns[i, field], lines[REST, field], low_y, high_y, shares_y, new[field])
            wrap_row(new[field], periodic)
        if k >= 0:
            new = lines[SWEPT + (k - 1) % 3]
            sweep(weights[0], stencil, faces_x, faces_y, periodic, right, lines, CORRECTED, k - 1, new)
        if k >= 2:
            sweep(weights[1], stencil, faces_x, faces_y, periodic, right, lines, SWEPT, k - 2, out[k - 2])


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
