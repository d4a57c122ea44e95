"""What the last two states say of the new one, and how far that was wrong."""

from __future__ import annotations

import numpy as np

from hydro.dynamics.lagrange.rows import add_difference, copy_row
from hydro.fields import MX, MY, E, N, P, U, V
from hydro.jit import kernel, part
from hydro.mesh import GHOSTS
from hydro.state import ROUND_OFF

TIGHT = 0.02  # 1 - n/n_p, below which the error of pressure counts less


@kernel(exact=True)
def look_ahead(gas, periodic, now, last, ratio, share, ahead, base):
    """Extrapolated n, u, v, p and the contribution of both states; returns whether n and T stay in bounds, and how many
    cells have less heat than `share` of their kinetic energy.

    Beyond a wall the extrapolated fields are flat; beyond a periodic side they are those of the other end.
    """
    nx = now.shape[1]
    weight = ratio * ratio / (1.0 + 2.0 * ratio)
    outside, cold = 0, 0
    for i in range(nx):
        k = i + GHOSTS
        for q in range(4):
            add_difference(now[q, i], last[q, i], weight, base[q, i])
            add_difference(now[q, i], last[q, i], ratio, ahead[q, k])
        found = primitive_row(gas, share, ahead[N, k], ahead[U, k], ahead[V, k], ahead[P, k])
        outside, cold = outside + found[0], cold + found[1]
    for q in range(4):
        for ghost in range(GHOSTS):
            below, above = (nx + ghost, GHOSTS + ghost) if periodic else (GHOSTS, nx + GHOSTS - 1)
            copy_row(ahead[q, below], ahead[q, ghost])
            copy_row(ahead[q, above], ahead[q, nx + GHOSTS + ghost])
    return outside == 0, cold


@part(exact=True)
def primitive_row(gas, share, density, momentum_x, momentum_y, energy):
    """Turn conserved fields of a row into n, u, v, p.

    Returns in how many cells n or T is out of bounds, and how many have less heat than `share` of their kinetic energy.
    """
    outside, cold, packed = 0, 0, gas.packing_density()
    for j in range(np.uint64(density.size)):
        n = density[j]
        over = 1.0 / n
        u, v = momentum_x[j] * over, momentum_y[j] * over
        kinetic = 0.5 * (u * u + v * v)
        T = energy[j] * over - kinetic
        momentum_x[j], momentum_y[j], energy[j] = u, v, gas.pressure(n, T)
        outside += 0 if (n > 0.0) & (n < packed) & (T > 0.0) else 1
        cold += 0 if share * kinetic <= T else 1
    return outside, cold


@kernel(exact=True)
def first_guess(gas, ahead, error, share, pressure, temperature):
    """A first guess of the unknowns: `ahead`, and `share` of its last `error`, at most half of itself."""
    for i in range(pressure.shape[0]):
        k = i + GHOSTS
        density, foreseen, error_P, error_T = ahead[N, k], ahead[P, k], error[0, i], error[1, i]
        P_row, T_row = pressure[i], temperature[i]
        for j in range(np.uint64(P_row.size)):
            p = foreseen[j]
            t = gas.temperature(density[j], p)
            P_row[j] = p + max(-0.5 * p, min(0.5 * p, share * error_P[j]))
            T_row[j] = t + max(-0.5 * t, min(0.5 * t, share * error_T[j]))


@kernel(exact=True)
def extrapolation_error(gas, ahead, pressure, temperature, error):
    """The unknowns less what was extrapolated of them, into `error`; to leading order the curvature in time."""
    for i in range(pressure.shape[0]):
        k = i + GHOSTS
        density, foreseen, error_P, error_T = ahead[N, k], ahead[P, k], error[0, i], error[1, i]
        P_row, T_row = pressure[i], temperature[i]
        for j in range(np.uint64(P_row.size)):
            error_P[j] = P_row[j] - foreseen[j]
            error_T[j] = T_row[j] - gas.temperature(density[j], foreseen[j])


@kernel
def unforeseen_change(gas, geometry, state, work):
    """Root mean square, over the box, of what the extrapolation (n, u, v, p) missed; infinite out of bounds.

    Density and pressure relative, velocity against sound; violent cells do not count, for no jump can be foreseen.
    Where gaps between grains are less than TIGHT of their distance, pressure is as little known as they are: there it
    counts in proportion to the gap.
    """
    total, area, ahead = 0.0, 0.0, work.ahead
    for i in range(state.shape[1]):
        k, width = i + GHOSTS, geometry.scale[i] * geometry.dx[i]
        missed, covered, outside = unforeseen_row(
            gas, width, geometry.dy, state[N, i], state[MX, i], state[MY, i], state[E, i],
            ahead[N, k], ahead[U, k], ahead[V, k], ahead[P, k], work.violence[i],
        )  # fmt: skip
        if outside > 0:
            return np.inf
        total, area = total + missed, area + covered
    return np.sqrt(total / area)


@part
def unforeseen_row(
    gas, width, dy, density, momentum_x, momentum_y, energy, n_ahead, u_ahead, v_ahead, p_ahead, violence
):  # fmt: skip
    """Of one row: the sum of squares, times areas, of what was missed; the area; how many cells are out of bounds."""
    total, area, outside, packed = 0.0, 0.0, 0, gas.packing_density()
    for j in range(np.uint64(dy.size)):
        n = density[j]
        over = 1.0 / n
        u, v = momentum_x[j] * over, momentum_y[j] * over
        kinetic = 0.5 * (u * u + v * v)
        T = energy[j] * over - kinetic
        p = gas.pressure(n, T)
        over_c = 1.0 / gas.sound_speed_at_pressure(n, p)
        in_n, in_p = n_ahead[j] * over - 1.0, min(1.0, gas.gap(n) / TIGHT) * (p_ahead[j] / p - 1.0)
        in_u, in_v = (u_ahead[j] - u) * over_c, (v_ahead[j] - v) * over_c
        total += (1.0 - violence[j]) * width * dy[j] * (in_n * in_n + in_p * in_p + in_u * in_u + in_v * in_v)
        area += width * dy[j]
        outside += 0 if (n > 0.0) & (n < packed) & (ROUND_OFF * kinetic < T) else 1
    return total, area, outside
