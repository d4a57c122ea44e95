"""The hydrodynamic update: one unsplit MUSCL-Hancock step of mass, momentum and energy.

Each cell's primitive variables (density, velocities, pressure) get limited slopes in both directions, are
moved half a step ahead with the quasi-linear equations, and are extrapolated to the four faces; a Riemann
solver turns the two states at each face into a flux. Pressure, not temperature, is reconstructed: a state of
uniform pressure at rest, however steep its density, has exactly zero mass and energy flux.

The kernel sweeps a tile row by row (a row is a line of cells along y, contiguous in memory) and keeps all
that it needs of the last rows in one scratch array of a few dozen rows, so that the state is read and written
once. Row offsets in the scratch array are compile-time constants: the compiler can then see that rows do not
overlap and use vector instructions.
"""

from __future__ import annotations

import numpy as np
from numba import prange

from hydro.dynamics.riemann import POSITIVE
from hydro.jit import inline, kernel, part
from hydro.mesh import GHOSTS
from hydro.mesh.geometry import OPEN
from hydro.walls.boundary import HIGH, LOW

TILE = 128  # cells of a row that are updated at once
ROW = TILE + 2 * GHOSTS
SCRATCH = 44 * ROW

# Places in the scratch array, as column indices of its one long line: unsigned, so that no index can be negative
# (a possibly negative one would wrap around, and a loop with such indices is not vectorized).
ONE, TWO = np.uint64(1), np.uint64(2)
# The rows of a group of four: density, u, v, pressure, or the fluxes of mass, two momenta and energy.
N, U, V, P = (np.uint64(ROW * row) for row in range(4))
(
    BEHIND, HERE, AHEAD,  # primitive variables of rows i-1, i, i+1
    X_LOW, X_HIGH, Y_LOW, Y_HIGH,  # row i at its four faces, half a step ahead
    X_HIGH_BEHIND,  # row i-1 at its upper face
    FLUX_X, FLUX_X_BEHIND, FLUX_Y,  # fluxes through the lower faces of rows i and i-1, and through the y faces
) = (np.uint64(4 * ROW * group) for group in range(11))  # fmt: skip
GROUP = np.uint64(4 * ROW)


@kernel(parallel=True)
def advance(gas, limiter, riemann, dt, geometry, sides, fallen, old, new, scratch):
    """Advance `old` by `dt` into `new`, without sources.

    old, new: (4, nx, ny) density, two momenta, energy. sides: with ghost rows filled. fallen: see `hydro.dynamics.
    godunov.fallback`. scratch: (threads, SCRATCH).
    """
    nx, ny = old.shape[1:]
    tiles_y = (ny + TILE - 1) // TILE
    bands = scratch.shape[0]
    for band in prange(bands):
        for tile in range(tiles_y):
            sweep(
                gas, limiter, riemann, dt, geometry, sides, fallen, old, new, scratch[band],
                band * nx // bands, (band + 1) * nx // bands, tile * TILE, min(ny, (tile + 1) * TILE),
            )  # fmt: skip


@part
def sweep(gas, limiter, riemann, dt, geometry, sides, fallen, old, new, s, i0, i1, j0, j1):
    """Advance the cells [i0, i1) x [j0, j1), at most TILE of them in y; `s` is one thread's scratch."""
    ny = old.shape[2]
    count = np.uint64(j1 - j0)
    load_row(gas, sides, old, s, i0 - 2, j0, j1, HERE)
    load_row(gas, sides, old, s, i0 - 1, j0, j1, AHEAD)
    for i in range(i0 - 1, i1 + 1):
        for k in range(GROUP):
            s[BEHIND + N + k] = s[HERE + N + k]
            s[HERE + N + k] = s[AHEAD + N + k]
            s[X_HIGH_BEHIND + N + k] = s[X_HIGH + N + k]
            s[FLUX_X_BEHIND + k] = s[FLUX_X + N + k]
        load_row(gas, sides, old, s, i + 1, j0, j1, AHEAD)
        face_states(gas, limiter, dt, geometry.spacing_x[:, i + GHOSTS], geometry.spacing_y, s, j0, j1)
        if i >= i0:
            fluxes_x(gas, riemann, s, count)
            if fallen.rows[i] or fallen.rows[i + 1]:
                fall_back_x(gas, fallen, s, i, j0, count)
            if geometry.pattern_x[i] != OPEN:
                narrow_x(geometry.aperture_x[geometry.pattern_x[i]], s, j0, count)
        if i > i0:
            update_row(geometry, dt, old, new, s, i - 1, j0, j1)
        if i < i1:
            fluxes_y(gas, riemann, s, count)
            if fallen.rows[i + 1]:
                fall_back_y(gas, fallen.cells[i + 1], s, j0, count)
            aperture = geometry.aperture_y[geometry.pattern_y[i]]
            if j0 == 0:
                narrow_face(aperture[0], s, FLUX_Y + TWO, U)
            if j1 == ny:
                narrow_face(aperture[ny], s, FLUX_Y + TWO + count, U)


@inline
def primitive(gas, density, momentum_x, momentum_y, energy):
    """Density, velocities and pressure of a cell."""
    u = momentum_x / density
    v = momentum_y / density
    return density, u, v, (energy - 0.5 * density * (u * u + v * v)) * gas.compressibility(density)


@part
def load_cells(gas, old, i, j0, j1, s, start):
    """Primitive variables of the cells [j0, j1) of row i into the scratch array from `start` on."""
    density, momentum_x, momentum_y, energy = old[0, i, j0:j1], old[1, i, j0:j1], old[2, i, j0:j1], old[3, i, j0:j1]
    for k in range(np.uint64(j1 - j0)):
        n, u, v, p = primitive(gas, density[k], momentum_x[k], momentum_y[k], energy[k])
        s[start + N + k] = n
        s[start + U + k] = u
        s[start + V + k] = v
        s[start + P + k] = p


@part
def copy_cells(ghosts, j0, j1, s, start):
    """The columns [j0, j1) of a ghost row (4, m) into the scratch array from `start` on."""
    for q in range(4):
        row, values = start + np.uint64(q * ROW), ghosts[q, j0:j1]
        for k in range(np.uint64(j1 - j0)):
            s[row + k] = values[k]


@part
def load_row(gas, sides, old, s, i, j0, j1, row):
    """Primitive variables of row i, ghost cells included, into the scratch row `row`."""
    nx, ny = old.shape[1:]
    first, last = max(j0 - GHOSTS, 0), min(j1 + GHOSTS, ny)
    at = row + np.uint64(first - j0 + GHOSTS)
    if 0 <= i < nx:
        load_cells(gas, old, i, first, last, s, at)
    elif i < 0:
        copy_cells(sides.ghost_x[LOW, -1 - i], first, last, s, at)
    else:
        copy_cells(sides.ghost_x[HIGH, i - nx], first, last, s, at)
    k = i + GHOSTS
    for ghost in range(GHOSTS):
        if j0 == 0:
            copy_cells(sides.ghost_y[LOW, ghost], k, k + 1, s, row + np.uint64(GHOSTS - 1 - ghost))
        if j1 == ny:
            copy_cells(sides.ghost_y[HIGH, ghost], k, k + 1, s, row + np.uint64(j1 - j0 + GHOSTS + ghost))


@part
def face_states(gas, limiter, dt, spacing_x, spacing_y, s, j0, j1):
    """States of row `HERE` at its four faces, half a step ahead; not numbers where one of them is inadmissible."""
    packed = gas.packing_density()
    half_x = 0.5 * dt / spacing_x[0]
    behind_x, ahead_x = spacing_x[1], spacing_x[2]
    j2 = j1 + 2 * GHOSTS
    widths_y, lows_y, highs_y = spacing_y[0, j0:j2], spacing_y[1, j0:j2], spacing_y[2, j0:j2]
    for k in range(ONE, np.uint64(j1 - j0 + 2 * GHOSTS - 1)):
        half_y = 0.5 * dt / widths_y[k]
        low_y, high_y = lows_y[k], highs_y[k]
        n, u, v, p = s[HERE + N + k], s[HERE + U + k], s[HERE + V + k], s[HERE + P + k]

        n_x = limiter.limited((n - s[BEHIND + N + k]) * behind_x, (s[AHEAD + N + k] - n) * ahead_x)
        u_x = limiter.limited((u - s[BEHIND + U + k]) * behind_x, (s[AHEAD + U + k] - u) * ahead_x)
        v_x = limiter.limited((v - s[BEHIND + V + k]) * behind_x, (s[AHEAD + V + k] - v) * ahead_x)
        p_x = limiter.limited((p - s[BEHIND + P + k]) * behind_x, (s[AHEAD + P + k] - p) * ahead_x)

        n_y = limiter.limited((n - s[HERE + N + k - ONE]) * low_y, (s[HERE + N + k + ONE] - n) * high_y)
        u_y = limiter.limited((u - s[HERE + U + k - ONE]) * low_y, (s[HERE + U + k + ONE] - u) * high_y)
        v_y = limiter.limited((v - s[HERE + V + k - ONE]) * low_y, (s[HERE + V + k + ONE] - v) * high_y)
        p_y = limiter.limited((p - s[HERE + P + k - ONE]) * low_y, (s[HERE + P + k + ONE] - p) * high_y)

        stiffness = p * gas.adiabatic_exponent(n)
        lightness = 1.0 / n
        n_half = n - half_x * (u * n_x + n * u_x) - half_y * (v * n_y + n * v_y)
        u_half = u - half_x * (u * u_x + lightness * p_x) - half_y * v * u_y
        v_half = v - half_x * u * v_x - half_y * (v * v_y + lightness * p_y)
        p_half = p - half_x * (u * p_x + stiffness * u_x) - half_y * (v * p_y + stiffness * v_y)
        reach_n, reach_p = 0.5 * max(abs(n_x), abs(n_y)), 0.5 * max(abs(p_x), abs(p_y))
        allowed = (n_half > reach_n) & (n_half + reach_n < packed) & (p_half > reach_p)
        n_half = n_half if allowed else np.nan

        s[X_LOW + N + k] = n_half - 0.5 * n_x
        s[X_HIGH + N + k] = n_half + 0.5 * n_x
        s[Y_LOW + N + k] = n_half - 0.5 * n_y
        s[Y_HIGH + N + k] = n_half + 0.5 * n_y
        s[X_LOW + U + k] = u_half - 0.5 * u_x
        s[X_HIGH + U + k] = u_half + 0.5 * u_x
        s[Y_LOW + U + k] = u_half - 0.5 * u_y
        s[Y_HIGH + U + k] = u_half + 0.5 * u_y
        s[X_LOW + V + k] = v_half - 0.5 * v_x
        s[X_HIGH + V + k] = v_half + 0.5 * v_x
        s[Y_LOW + V + k] = v_half - 0.5 * v_y
        s[Y_HIGH + V + k] = v_half + 0.5 * v_y
        s[X_LOW + P + k] = p_half - 0.5 * p_x
        s[X_HIGH + P + k] = p_half + 0.5 * p_x
        s[Y_LOW + P + k] = p_half - 0.5 * p_y
        s[Y_HIGH + P + k] = p_half + 0.5 * p_y


@part
def fluxes_x(gas, riemann, s, count):
    """Fluxes through the faces between row i-1 and row i."""
    for k in range(TWO, count + TWO):
        mass, normal, transverse, energy = riemann.flux(
            gas,
            s[X_HIGH_BEHIND + N + k], s[X_HIGH_BEHIND + U + k], s[X_HIGH_BEHIND + V + k], s[X_HIGH_BEHIND + P + k],
            s[X_LOW + N + k], s[X_LOW + U + k], s[X_LOW + V + k], s[X_LOW + P + k],
        )  # fmt: skip
        s[FLUX_X + N + k] = mass
        s[FLUX_X + U + k] = normal
        s[FLUX_X + V + k] = transverse
        s[FLUX_X + P + k] = energy


@part
def fluxes_y(gas, riemann, s, count):
    """Fluxes through the y faces of row i; column k holds the face below cell k."""
    for k in range(TWO, count + TWO + ONE):
        mass, normal, transverse, energy = riemann.flux(
            gas,
            s[Y_HIGH + N + k - ONE], s[Y_HIGH + V + k - ONE], s[Y_HIGH + U + k - ONE], s[Y_HIGH + P + k - ONE],
            s[Y_LOW + N + k], s[Y_LOW + V + k], s[Y_LOW + U + k], s[Y_LOW + P + k],
        )  # fmt: skip
        s[FLUX_Y + N + k] = mass
        s[FLUX_Y + U + k] = transverse
        s[FLUX_Y + V + k] = normal
        s[FLUX_Y + P + k] = energy


@part
def fall_back_x(gas, fallen, s, i, j0, count):
    """First-order fluxes through the faces between row i-1 and row i where a cell beside them has fallen back."""
    for k in range(TWO, count + TWO):
        j = j0 + k - ONE
        if fallen.cells[i, j] or fallen.cells[i + 1, j]:
            mass, normal, transverse, energy = POSITIVE.flux(
                gas,
                s[BEHIND + N + k], s[BEHIND + U + k], s[BEHIND + V + k], s[BEHIND + P + k],
                s[HERE + N + k], s[HERE + U + k], s[HERE + V + k], s[HERE + P + k],
            )  # fmt: skip
            s[FLUX_X + N + k] = mass
            s[FLUX_X + U + k] = normal
            s[FLUX_X + V + k] = transverse
            s[FLUX_X + P + k] = energy


@part
def fall_back_y(gas, fallen_row, s, j0, count):
    """First-order fluxes through the y faces of a row where a cell beside them has fallen back."""
    for k in range(TWO, count + TWO + ONE):
        j = j0 + k - TWO
        if fallen_row[j] or fallen_row[j + 1]:
            mass, normal, transverse, energy = POSITIVE.flux(
                gas,
                s[HERE + N + k - ONE], s[HERE + V + k - ONE], s[HERE + U + k - ONE], s[HERE + P + k - ONE],
                s[HERE + N + k], s[HERE + V + k], s[HERE + U + k], s[HERE + P + k],
            )  # fmt: skip
            s[FLUX_Y + N + k] = mass
            s[FLUX_Y + U + k] = transverse
            s[FLUX_Y + V + k] = normal
            s[FLUX_Y + P + k] = energy


@part
def narrow_x(aperture, s, j0, count):
    """Narrow the faces below row i to their apertures, (ny,)."""
    for k in range(count):
        narrow_face(aperture[j0 + k], s, FLUX_X + TWO + k, V)


@inline
def narrow_face(aperture, s, face, transverse):
    """Nothing but pressure acts where a face is closed: mirror images give that to round-off, and here exactly."""
    s[face] *= aperture
    s[face + transverse] *= aperture
    s[face + P] *= aperture


@part
def update_row(geometry, dt, old, new, s, i, j0, j1):
    """Add the flux differences of row i."""
    widths, scale = geometry.dy[j0:j1], geometry.scale[i]
    low, high = geometry.scale_x[i], geometry.scale_x[i + 1]
    dt_dx = dt / (scale * geometry.dx[i])
    for q in range(4):
        row = np.uint64(q * ROW) + TWO
        lower, upper, side = FLUX_X_BEHIND + row, FLUX_X + row, FLUX_Y + row
        before, after = old[q, i, j0:j1], new[q, i, j0:j1]
        for k in range(np.uint64(j1 - j0)):
            through_y = dt / (scale * widths[k]) * (s[side + k + ONE] - s[side + k])
            after[k] = before[k] - dt_dx * (high * s[upper + k] - low * s[lower + k]) - through_y


def scratch_for(threads: int) -> np.ndarray:
    """Scratch rows for `advance`, shape (threads, SCRATCH)."""
    return np.zeros((threads, SCRATCH))
