"""Conduction, cooling and wall heat together at frozen density, by super-time-stepping.

    n dT/dt = div(kappa grad T) - I,    kappa = k(n) T^(1/2),   I = q(n) T^(3/2)

The heat operator here is the only one: its face conductivities (the mean of the two cells'), cooling and wall
flux are those of every solver, so that a state which balances them is steady for all.

RKL2 (Meyer, Balsara and Aslam, J. Comput. Phys. 257, 594, 2014) is a second-order Runge-Kutta method whose s
stages reach (s^2+s-2)/4 explicit steps: conduction never sets the step. Balanced terms give zero in every
stage, so a steady state stays. The heat given by the wall and lost in collisions go through the same
recurrence as the temperature, so that the books balance to round-off.

Cooling is then done again, cell by cell, under the mean conducted heat of the super-step and to fourth order: in a
gas that nothing heats, RKL2's relative error of about 0.56 (dt/t_c)^2 would be too coarse.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange

from hydro.dynamics.reduce import store_largest
from hydro.jit import inline, kernel, part

COOLING_FRACTION = 0.03  # of a cooling time at most, in one super-step
CHANGE = 0.3  # of the temperature at most, in one super-step, by the rates at its start
SAFETY = 1.2  # of the spectral radius, for the conductivity's own dependence on temperature
MOST_EXPLICIT_STEPS, MOST_SUPERSTEPS = 2e5, 1000

# Fields of the work array, each (nx, ny).
START, LAST, NEXT = 0, 1, 2  # temperature: at the start, and at the last two stages, which change places
LOST = 2  # offset from LAST and NEXT to the energy per grain lost in collisions by the same stages
CONDUCTED, COOLED = 5, 6  # rates at the start: heat conducted into a grain, heat lost by it
CONDUCTION, COOLING, INVERSE = 7, 8, 9  # kappa/T^(1/2), I/(n T^(3/2)), 1/n
FIELDS = 10

# Rows of a thread's scratch, each (ny + 2,), with a ghost column on both sides.
K_BEHIND, T_HERE, K_HERE, T_AHEAD, K_AHEAD, FLUX_BELOW, FLUX_ABOVE, DIVERGENCE, CONDUCTANCE = range(9)
SCRATCH_ROWS = 9

# Sums over a row of cells, each (nx,).
LOSS, RADIUS, RATE = range(3)
SUMS = 3

ONE = np.uint64(1)


class HeatArrays(NamedTuple):
    """Work space of the heat kernels: 80 bytes per cell.

    `wall_temperature`, shape (ny,), is the first guess for the temperature of the wall face. Zeros mean that
    there is none yet. It has to be saved for a run to go on with the same bits.
    """

    work: np.ndarray  # (FIELDS, nx, ny)
    scratch: np.ndarray  # (threads, SCRATCH_ROWS, ny+2)
    sums: np.ndarray  # (SUMS, nx)
    wall_temperature: np.ndarray  # (ny,)
    wall_flux: np.ndarray  # (ny,), heat from the driving wall per length and time

    @classmethod
    def of(cls, mesh, threads: int) -> HeatArrays:
        nx, ny = mesh.cells
        scratch = np.zeros((threads, SCRATCH_ROWS, ny + 2))
        return cls(np.zeros((FIELDS, nx, ny)), scratch, np.zeros((SUMS, nx)), np.zeros(ny), np.zeros(ny))


@kernel
def advance(gas, wall, geometry, arrays, state, dt):
    """Heat the conserved `state` (4, nx, ny) for `dt`; returns the energies given by the wall and lost in collisions.

    Both are NaN if the step is out of all proportion to the rates of conduction and cooling.
    """
    begin(gas, state, arrays)
    given, lost, remaining = 0.0, 0.0, dt
    for _ in range(MOST_SUPERSTEPS):
        power = drive(gas, wall, geometry, arrays, START)
        start_rates(geometry, arrays)
        step = superstep_size(arrays, remaining)
        given += superstep(gas, wall, geometry, arrays, power, step)
        correct(geometry, arrays, state, step)
        lost += total(arrays.sums[LOSS])
        if step == remaining:
            return given, lost
        remaining -= step
    return np.nan, np.nan


@part
def superstep_size(arrays, remaining):
    """The next super-step: all that remains, if rates and stages allow it; rather two halves than a sliver."""
    longest = min(1.0 / largest(arrays.sums[RATE]), MOST_EXPLICIT_STEPS / (SAFETY * largest(arrays.sums[RADIUS])))
    if longest >= remaining:
        return remaining
    return min(longest, 0.5 * remaining)


@part
def superstep(gas, wall, geometry, arrays, power, dt):
    """One RKL2 step of temperature and losses, from START to LAST; returns the energy given by the wall.

    power: what the wall gives at the start.
    """
    stages = stage_count(0.5 * dt * SAFETY * largest(arrays.sums[RADIUS]))
    unit = 4.0 / (stages * stages + stages - 2.0)
    first_stage(arrays.work, unit * dt / 3.0)
    given_before, given = 0.0, unit * dt / 3.0 * power
    for j in range(2, stages + 1):
        mu, nu, rate, start_rate = coefficients(j, unit)
        last = LAST if j % 2 == 0 else NEXT  # an odd number of stages: the result is in LAST
        given_next = mu * given + nu * given_before + dt * start_rate * power
        given_next += dt * rate * drive(gas, wall, geometry, arrays, last)
        stage(geometry, arrays, last, mu, nu, rate * dt, start_rate * dt)
        given_before, given = given, given_next
    return given


@part
def drive(gas, wall, geometry, arrays, field):
    """Heat flux from the wall x = 1 for the temperatures in `field`; returns its integral over the wall."""
    nx, ny = arrays.work.shape[1:]
    if geometry.periodic_x:
        return 0.0
    half_width = 0.5 * geometry.dx[nx - 1]
    inverse, T, guess = arrays.work[INVERSE, nx - 1], arrays.work[field, nx - 1], arrays.wall_temperature
    power = 0.0
    for j in range(ny):
        start = guess[j] if guess[j] > 0.0 else T[j]
        flux, guess[j] = wall.face(gas, 1.0 / inverse[j], T[j], half_width, start)
        arrays.wall_flux[j] = flux
        power += flux * geometry.dy[j]
    return power


@inline
def total(values):
    """Sum of an array."""
    result = 0.0
    for value in values:
        result += value
    return result


@inline
def largest(values):
    """Maximum of an array that is nowhere negative; NaN if one is in it."""
    result = 0.0
    for value in values:
        result = result if value <= result else value
    return result


@inline
def stage_count(explicit_steps):
    """The smallest odd number of stages, three or more, that reaches so many explicit steps."""
    enough = int(np.ceil(0.5 * (np.sqrt(9.0 + 16.0 * min(explicit_steps, MOST_EXPLICIT_STEPS)) - 1.0)))
    return max(3, enough + 1 - enough % 2)


@inline
def weight(j):
    """b_j of RKL2."""
    return 1.0 / 3.0 if j < 2 else (j * j + j - 2.0) / (2.0 * j * (j + 1.0))


@inline
def coefficients(j, unit):
    """mu, nu, and the weights of the last and of the first rate in stage j of RKL2."""
    mu = (2.0 * j - 1.0) / j * weight(j) / weight(j - 1)
    nu = -(j - 1.0) / j * weight(j) / weight(j - 2)
    return mu, nu, mu * unit, (weight(j - 1) - 1.0) * mu * unit


@kernel(parallel=True)
def begin(gas, state, arrays):
    """Temperatures and coefficients of `state`."""
    for i in prange(state.shape[1]):
        begin_row(gas, state[0, i], state[1, i], state[2, i], state[3, i], arrays.work, i)


@part
def begin_row(gas, density, momentum_x, momentum_y, energy, work, i):
    """Row i of `begin`."""
    temperature, conduction, cooling, inverse = work[START, i], work[CONDUCTION, i], work[COOLING, i], work[INVERSE, i]
    for j in range(np.uint64(density.size)):
        n = density[j]
        over = 1.0 / n
        T = (energy[j] - 0.5 * (momentum_x[j] ** 2 + momentum_y[j] ** 2) * over) * over
        temperature[j] = T
        conduction[j] = gas.conductivity_coefficient(n)
        cooling[j] = gas.cooling_coefficient(n) * over
        inverse[j] = over


@part
def load_line(work, field, i, temperature, conductivity):
    """Temperature and conductivity of row i into scratch rows, from column 1 on."""
    T, coefficient = work[field, i], work[CONDUCTION, i]
    for j in range(np.uint64(T.size)):
        temperature[j + ONE] = T[j]
        conductivity[j + ONE] = coefficient[j] * np.sqrt(T[j])


@part
def flux_line(geometry, wall_flux, face, s):
    """Heat conducted through x face `face` toward smaller x, into scratch row FLUX_ABOVE.

    Its cells are in the rows HERE and AHEAD. No heat comes from the wall x = 0.
    """
    T, K, T_ahead, K_ahead, flux = s[T_HERE], s[K_HERE], s[T_AHEAD], s[K_AHEAD], s[FLUX_ABOVE]
    conductance = 0.5 * geometry.inverse_x[face]
    if 0 < face < geometry.dx.size or geometry.periodic_x:
        for k in range(np.uint64(flux.size)):
            flux[k] = conductance * (K[k] + K_ahead[k]) * (T_ahead[k] - T[k])
    else:
        for k in range(np.uint64(wall_flux.size)):
            flux[k + ONE] = 0.0 if face == 0 else wall_flux[k]


@part
def start_lines(geometry, arrays, field, i, s):
    """Prepare the scratch rows for a sweep that starts with row i."""
    before = (i - 1) % arrays.work.shape[1]
    load_line(arrays.work, field, before, s[T_HERE], s[K_HERE])
    load_line(arrays.work, field, i, s[T_AHEAD], s[K_AHEAD])
    flux_line(geometry, arrays.wall_flux, i, s)


@part
def shift_lines(s):
    """What was ahead is here, what was here is behind."""
    K_behind, T, K, T_ahead, K_ahead = s[K_BEHIND], s[T_HERE], s[K_HERE], s[T_AHEAD], s[K_AHEAD]
    below, above = s[FLUX_BELOW], s[FLUX_ABOVE]
    for k in range(np.uint64(T.size)):
        K_behind[k] = K[k]
        T[k] = T_ahead[k]
        K[k] = K_ahead[k]
        below[k] = above[k]


@part
def divergence_line(geometry, arrays, field, i, s):
    """Divergence of the conducted heat in row i into scratch row DIVERGENCE; rows must be taken in order."""
    nx, ny = arrays.work.shape[1:]
    T, K, below, above, divergence = s[T_HERE], s[K_HERE], s[FLUX_BELOW], s[FLUX_ABOVE], s[DIVERGENCE]
    shift_lines(s)
    T[0], T[ny + 1] = (T[ny], T[1]) if geometry.periodic_y else (T[1], T[ny])
    K[0], K[ny + 1] = (K[ny], K[1]) if geometry.periodic_y else (K[1], K[ny])
    load_line(arrays.work, field, (i + 1) % nx, s[T_AHEAD], s[K_AHEAD])
    flux_line(geometry, arrays.wall_flux, i + 1, s)
    over_dx = 1.0 / geometry.dx[i]
    dy, inverse_y = geometry.dy, geometry.inverse_y
    for k in range(ONE, np.uint64(ny + 1)):
        j = k - ONE
        up = 0.5 * inverse_y[k] * (K[k] + K[k + ONE]) * (T[k + ONE] - T[k])
        down = 0.5 * inverse_y[j] * (K[j] + K[k]) * (T[k] - T[j])
        divergence[k] = over_dx * (above[k] - below[k]) + (up - down) / dy[j]


@part
def conductance_line(geometry, arrays, i, s):
    """Sum of a cell's face conductances over its area into scratch row CONDUCTANCE, after `divergence_line`."""
    ny = arrays.work.shape[2]
    K_behind, K, K_ahead, conductance = s[K_BEHIND], s[K_HERE], s[K_AHEAD], s[CONDUCTANCE]
    dy, inverse_y = geometry.dy, geometry.inverse_y
    below, above = geometry.inverse_x[i], geometry.inverse_x[i + 1]
    over_dx = 1.0 / geometry.dx[i]
    for k in range(ONE, np.uint64(ny + 1)):
        j = k - ONE
        x_part = below * (K_behind[k] + K[k]) + above * (K[k] + K_ahead[k])
        y_part = inverse_y[j] * (K[j] + K[k]) + inverse_y[k] * (K[k] + K[k + ONE])
        conductance[k] = 0.5 * (x_part * over_dx + y_part / dy[j])


@part
def wall_conductance(geometry, arrays, s):
    """Add that of the driving wall to the last row's conductances: what the heat law gave, or the cell's own."""
    over_dx = 1.0 / geometry.dx[-1]
    T, K, conductance = s[T_HERE], s[K_HERE], s[CONDUCTANCE]
    flux, wall_temperature = arrays.wall_flux, arrays.wall_temperature
    for j in range(flux.size):
        gap = abs(wall_temperature[j] - T[j + 1])
        given = abs(flux[j]) / gap if gap > 0.0 else 0.0
        conductance[j + 1] += max(given, 2.0 * over_dx * K[j + 1]) * over_dx


@kernel(parallel=True)
def start_rates(geometry, arrays):
    """Rates of conduction and cooling at the start; per row, what they and the spectral radius ask of the step."""
    work = arrays.work
    nx, bands = work.shape[1], arrays.scratch.shape[0]
    for band in prange(bands):
        s = arrays.scratch[band]
        first, stop = band * nx // bands, (band + 1) * nx // bands
        start_lines(geometry, arrays, START, first, s)
        for i in range(first, stop):
            divergence_line(geometry, arrays, START, i, s)
            conductance_line(geometry, arrays, i, s)
            if i == nx - 1 and not geometry.periodic_x:
                wall_conductance(geometry, arrays, s)
            start_row(work, i, s[DIVERGENCE], s[CONDUCTANCE], arrays.sums)


@part
def start_row(work, i, divergence, conductance, sums):
    """Rates of row i at the start from its divergence."""
    T, inverse, cooling = work[START, i], work[INVERSE, i], work[COOLING, i]
    conducted, cooled = work[CONDUCTED, i], work[COOLED, i]
    radius, rate = work[NEXT, i], work[LAST, i]
    for j in range(np.uint64(T.size)):
        root = np.sqrt(T[j])
        conducted[j] = divergence[j + ONE] * inverse[j]
        cooled[j] = cooling[j] * T[j] * root
        radius[j] = 2.0 * conductance[j + ONE] * inverse[j] + 1.5 * cooling[j] * root
        rate[j] = max(cooled[j] / COOLING_FRACTION, abs(conducted[j] - cooled[j]) / CHANGE) / T[j]
    store_largest(radius, sums[RADIUS], i)
    store_largest(rate, sums[RATE], i)


@kernel(parallel=True)
def first_stage(work, rate):
    """Stage 1 of RKL2 into LAST, with the start in NEXT."""
    for i in prange(work.shape[1]):
        first_row(work, i, rate)


@part
def first_row(work, i, rate):
    """Row i of the first stage."""
    start, conducted, cooled = work[START, i], work[CONDUCTED, i], work[COOLED, i]
    T, T_next, lost, lost_next = work[LAST, i], work[NEXT, i], work[LAST + LOST, i], work[NEXT + LOST, i]
    for j in range(np.uint64(start.size)):
        T[j] = start[j] + rate * (conducted[j] - cooled[j])
        T_next[j] = start[j]
        lost[j] = rate * cooled[j]
        lost_next[j] = 0.0


@kernel(parallel=True)
def stage(geometry, arrays, last, mu, nu, rate, start_rate):
    """A later stage of RKL2, from the temperatures in field `last` into the other one."""
    work = arrays.work
    nx, bands = work.shape[1], arrays.scratch.shape[0]
    for band in prange(bands):
        s = arrays.scratch[band]
        first, stop = band * nx // bands, (band + 1) * nx // bands
        start_lines(geometry, arrays, last, first, s)
        for i in range(first, stop):
            divergence_line(geometry, arrays, last, i, s)
            stage_row(work, last, i, s[DIVERGENCE], mu, nu, rate, start_rate)


@part
def stage_row(work, last, i, divergence, mu, nu, rate, start_rate):
    """Row i of a later stage."""
    following = LAST + NEXT - last
    T, T_next, T_start = work[last, i], work[following, i], work[START, i]
    lost, lost_next = work[last + LOST, i], work[following + LOST, i]
    conducted, cooled = work[CONDUCTED, i], work[COOLED, i]
    inverse, cooling = work[INVERSE, i], work[COOLING, i]
    rest = 1.0 - mu - nu
    for j in range(np.uint64(T.size)):
        loss = cooling[j] * T[j] * np.sqrt(T[j])
        change = rate * (divergence[j + ONE] * inverse[j] - loss) + start_rate * (conducted[j] - cooled[j])
        T_next[j] = mu * T[j] + nu * T_next[j] + rest * T_start[j] + change
        lost_next[j] = mu * lost[j] + nu * lost_next[j] + rate * loss + start_rate * cooled[j]


@kernel(parallel=True)
def correct(geometry, arrays, state, dt):
    """Cool each cell to fourth order under its mean conducted heat; put the change into energy and START."""
    for i in prange(state.shape[1]):
        correct_row(geometry, arrays.work, arrays.sums, state[0, i], state[3, i], i, dt)


@part
def correct_row(geometry, work, sums, density, energy, i, dt):
    """Row i of `correct`.

    With d the conducted heat per grain and time, and i = c T^(3/2) the loss, dT/dt = d - i; the loss over dt
    is the Taylor series of i along this trajectory. It is no good where the temperature changes by as much as
    itself, beside a wall that is suddenly hot: there RKL2's own loss stands.
    """
    T, after, lost, cooling = work[START, i], work[LAST, i], work[LAST + LOST, i], work[COOLING, i]
    total = 0.0
    for j in range(np.uint64(density.size)):
        conducted = after[j] - T[j] + lost[j]
        c, root = cooling[j], np.sqrt(T[j])
        i0 = c * T[j] * root
        gain = conducted / dt - i0
        i1 = 1.5 * c * root * gain
        i2 = 1.5 * c * (0.5 * gain * gain / root - root * i1)
        i3 = -1.5 * c * (0.25 * gain * gain * gain / (T[j] * root) + 1.5 * gain * i1 / root + root * i2)
        loss = dt * (i0 + dt * (0.5 * i1 + dt / 6.0 * (i2 + 0.25 * dt * i3)))
        loss = loss if abs(conducted) < 0.5 * T[j] else lost[j]
        change = conducted - loss
        T[j] += change
        energy[j] += density[j] * change
        total += density[j] * loss * geometry.dy[j]
    sums[LOSS, i] = total * geometry.dx[i]


@kernel
def wall_heat(gas, wall, density, temperature, half_width):
    """(heat flux, temperature) of the wall face, for last cells of the given density and temperature; all (ny,)."""
    flux, faces = temperature.copy(), temperature.copy()
    for j in range(faces.size):
        flux[j], faces[j] = wall.face(gas, density[j], temperature[j], half_width, temperature[j])
    return flux, faces
