"""Conduction, cooling and wall heat together at frozen density, by super-time-stepping.

    n dT/dt = div(kappa grad T) - I,    kappa = k(n) T^(1/2),   I = q(n) T^(3/2)

The face conductivities (the mean of the two cells'), cooling and wall heat are those of every solver, so that a state
which balances them is steady for all.

Conduction never sets the step (see `hydro.numerics.rkl2`). Balanced terms give zero in every stage, so a steady state
stays. The heat given by the walls and lost in collisions go through the same recurrence as the temperature, so that
the books balance to round-off.

Cooling is then done again, cell by cell, under the mean conducted heat of the super-step and to fourth order: in a
gas that nothing heats, RKL2's relative error of about 0.56 (dt/t_c)^2 would be too coarse.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import prange

from hydro.fields import MX, MY, E, N
from hydro.gas import Closure
from hydro.gas.conduction import conducted_heat, face_conductance
from hydro.gas.elastic import inelastic_share
from hydro.jit import kernel, part
from hydro.mesh import Geometry, Mesh
from hydro.numerics.reduce import largest, store_largest, total
from hydro.numerics.rkl2 import MOST_EXPLICIT_STEPS, first_rate, stage_count, stage_weights
from hydro.walls.boundary import HEAT, HIGH, LOW, TEMPERATURE, Boundary, give_heat

COOLING_FRACTION = 0.03  # of a cooling time at most, in one super-step
CHANGE = 0.3  # of the temperature at most, in one super-step, by the rates at its start
SAFETY = 1.2  # of the spectral radius, for the conductivity's own dependence on temperature
MOST_SUPERSTEPS, MOST_STAGES = 1000, 20000  # in one step

# Fields of the work array, each (nx, ny).
START, LAST, NEXT = 0, 1, 2  # temperature: at the start, and at the last two stages, which change places
LOST = 2  # offset from LAST and NEXT to the energy per grain lost in collisions by the same stages
CONDUCTED, COOLED = 5, 6  # rates at the start: heat conducted into a grain, heat lost by it
CONDUCTION, COOLING, INVERSE = 7, 8, 9  # kappa/T^(1/2), I/(n T^(3/2)), 1/n
FIELDS = 10

# Rows of a thread's scratch, each (ny + 2,), with a ghost column on both sides. Those of neighbouring rows of cells
# take turns: temperatures, their roots and fluxes in two, conductivities in three.
TEMPERATURES, ROOTS, FLUXES, CONDUCTIVITIES, DIVERGENCE, CONDUCTANCE = 0, 2, 4, 6, 9, 10
SCRATCH_ROWS = 11

# Sums over a row of cells, each (nx,).
LOSS, RADIUS, RATE = range(3)
SUMS = 3

ONE = np.uint64(1)


class HeatArrays(NamedTuple):
    """Work space of the heat kernels: 80 bytes per cell."""

    work: np.ndarray  # (FIELDS, nx, ny)
    scratch: np.ndarray  # (threads, SCRATCH_ROWS, ny+2)
    sums: np.ndarray  # (SUMS, nx)

    @classmethod
    def of(cls, mesh: Mesh, threads: int) -> HeatArrays:
        nx, ny = mesh.cells
        return cls(np.zeros((FIELDS, nx, ny)), np.zeros((threads, SCRATCH_ROWS, ny + 2)), np.zeros((SUMS, nx)))


class Heat:
    """Conduction, cooling and the heat of walls on a mesh."""

    def __init__(self, gas: Closure, boundary: Boundary, mesh: Mesh, threads: int, elastic_below: float = 0.0):
        self.gas, self.elastic_below, self.boundary, self.geometry = gas, elastic_below, boundary, Geometry.of(mesh)
        self.arrays = HeatArrays.of(mesh, threads)

    def advance(self, state: np.ndarray, dt: float) -> tuple[float, float]:
        """Heat the conserved `state` (4, nx, ny) for `dt`; returns the energies given by walls and lost in collisions.

        Both are NaN if the step is out of all proportion to the rates of conduction and cooling. StepRejected where
        the law of a wall finds no heat.
        """
        boundary = self.boundary
        given, lost = advance(
            self.gas, self.elastic_below, boundary.laws_of_heat, self.geometry, boundary.sides, self.arrays, state, dt
        )  # fmt: skip
        if math.isnan(given):
            boundary.refuse_no_heat()
        return given, lost


@kernel
def advance(gas, elastic_below, heaters, geometry, sides, arrays, state, dt):
    """See `Heat.advance`. The loops here are compiled for the laws that are there, as a set; sweeps are not."""
    begin(gas, elastic_below, state, arrays)
    given, lost, remaining, stages = 0.0, 0.0, dt, 0
    for _ in range(MOST_SUPERSTEPS):
        power = give_heat(heaters, gas, state[N], arrays.work[START])
        start_rates(geometry, sides, arrays)
        radius = largest(arrays.sums[RADIUS])
        step = superstep_size(remaining, radius, largest(arrays.sums[RATE]))
        if np.isnan(power) or not step > 0.0:
            break
        count = stage_count(0.5 * step * SAFETY * radius)
        stages += count
        if stages > MOST_STAGES:
            break
        given += superstep(gas, heaters, geometry, sides, arrays, state[N], power, step, count)
        if np.isnan(given):
            break
        correct(geometry, elastic_below, arrays, state, step)
        lost += total(arrays.sums[LOSS])
        if step == remaining:
            return given, lost
        remaining -= step
    return np.nan, np.nan


@part
def superstep_size(remaining, radius, rate):
    """The next super-step: all that remains, if rates and stages allow it; rather two halves than a sliver.

    Not a number where a rate is none.
    """
    longest = min(1.0 / rate, MOST_EXPLICIT_STEPS / (SAFETY * radius))
    return remaining if longest >= remaining else min(longest, 0.5 * remaining)


@part
def superstep(gas, heaters, geometry, sides, arrays, density, power, dt, count):
    """Temperature and losses in `count` stages, an odd number, from START to LAST; returns the energy of the walls.

    power: what they give at the start. NaN where one finds no heat: what is beside it is then as its law met it.
    """
    work, last = arrays.work, LAST
    first_stage(work, first_rate(count) * dt)
    given_before, given = 0.0, first_rate(count) * dt * power
    for j in range(2, count + 1):
        mu, nu, rate, start_rate = stage_weights(j, count)
        power_now = give_heat(heaters, gas, density, work[last])
        if np.isnan(power_now):
            return np.nan
        given_next = mu * given + nu * given_before + dt * (start_rate * power + rate * power_now)
        stage(geometry, sides, arrays, last, mu, nu, rate * dt, start_rate * dt)
        given_before, given, last = given, given_next, LAST + NEXT - last
    return given


@kernel(parallel=True)
def begin(gas, elastic_below, state, arrays):
    """Temperatures and coefficients of `state`."""
    for i in prange(state.shape[1]):
        begin_row(gas, elastic_below, state[N, i], state[MX, i], state[MY, i], state[E, i], arrays.work, i)


@part
def begin_row(gas, elastic_below, density, momentum_x, momentum_y, energy, work, i):
    """Row i of `begin`."""
    temperature, conduction, cooling, inverse = work[START, i], work[CONDUCTION, i], work[COOLING, i], work[INVERSE, i]
    for j in range(np.uint64(density.size)):
        n = density[j]
        over = 1.0 / n
        T = (energy[j] - 0.5 * (momentum_x[j] ** 2 + momentum_y[j] ** 2) * over) * over
        temperature[j] = T
        conduction[j] = gas.conductivity_coefficient(n)
        cooling[j] = gas.cooling_coefficient(n) * over * inelastic_share(T, elastic_below)
        inverse[j] = over


@part
def lines_of(s, i):
    """Temperatures, their roots and conductivities of row i of the cells, in scratch; i >= -1."""
    turn = i + 6
    return s[TEMPERATURES + turn % 2], s[ROOTS + turn % 2], s[CONDUCTIVITIES + turn % 3]


@part
def load_lines(geometry, arrays, field, i, s):
    """Bring row i of the cells into scratch, with a ghost column on both sides."""
    nx, ny = arrays.work.shape[1:]
    T_row, coefficient = arrays.work[field, i % nx], arrays.work[CONDUCTION, i % nx]
    T, root, K = lines_of(s, i)
    for j in range(np.uint64(T_row.size)):
        k = j + ONE
        T[k] = T_row[j]
        root[k] = np.sqrt(T_row[j])
        K[k] = coefficient[j] * root[k]
    T[0], T[ny + 1] = (T[ny], T[1]) if geometry.periodic_y else (T[1], T[ny])
    K[0], K[ny + 1] = (K[ny], K[1]) if geometry.periodic_y else (K[1], K[ny])


@part
def flux_line(geometry, sides, face, s):
    """Heat conducted through the faces in x below row `face` toward smaller x, per length in y, into scratch.

    The cells on both sides must be there. Through closed sides goes the heat of the walls.
    """
    T, _, K = lines_of(s, face - 1)
    T_ahead, _, K_ahead = lines_of(s, face)
    flux, aperture = s[FLUXES + face % 2], geometry.aperture_x[geometry.pattern_x[face]]
    scale = geometry.scale_x[face]
    weight = scale * geometry.inverse_x[face]
    for j in range(np.uint64(aperture.size)):
        k = j + ONE
        flux[k] = aperture[j] * conducted_heat(weight, K[k], K_ahead[k], T[k], T_ahead[k])
    if face == 0 or face == geometry.dx.size:
        heat = sides.x[HIGH if face > 0 else LOW, HEAT]
        toward = scale if face > 0 else -scale
        for j in range(np.uint64(aperture.size)):
            flux[j + ONE] += toward * heat[j]


@part
def start_lines(geometry, sides, arrays, field, i, s):
    """Prepare the scratch for a sweep that starts with row i."""
    load_lines(geometry, arrays, field, i - 1, s)
    load_lines(geometry, arrays, field, i, s)
    flux_line(geometry, sides, i, s)


@part
def divergence_line(geometry, sides, arrays, field, i, s):
    """Divergence of the conducted heat in row i into scratch row DIVERGENCE; rows must be taken in order."""
    load_lines(geometry, arrays, field, i + 1, s)
    flux_line(geometry, sides, i + 1, s)
    T, _, K = lines_of(s, i)
    below, above, divergence = s[FLUXES + i % 2], s[FLUXES + (i + 1) % 2], s[DIVERGENCE]
    weight, over_dy, ny = geometry.weight_y[geometry.pattern_y[i]], geometry.over_dy, geometry.dy.size
    over_scale = 1.0 / geometry.scale[i]
    over_dx, over_square = over_scale / geometry.dx[i], over_scale * over_scale
    for k in range(ONE, np.uint64(ny + 1)):
        j = k - ONE
        up = conducted_heat(weight[k], K[k], K[k + ONE], T[k], T[k + ONE])
        down = conducted_heat(weight[j], K[j], K[k], T[j], T[k])
        divergence[k] = over_dx * (above[k] - below[k]) + (over_square * over_dy[j]) * (up - down)
    divergence[1] += over_scale * over_dy[0] * sides.y[LOW, HEAT, i]
    divergence[ny] += over_scale * over_dy[ny - 1] * sides.y[HIGH, HEAT, i]


@part
def conductance_line(geometry, i, s):
    """Sum of a cell's face conductances over its area into scratch row CONDUCTANCE, after `divergence_line`."""
    K_behind, K, K_ahead = lines_of(s, i - 1)[2], lines_of(s, i)[2], lines_of(s, i + 1)[2]
    inverse_y, over_dy, conductance = geometry.inverse_y, geometry.over_dy, s[CONDUCTANCE]
    over_scale = 1.0 / geometry.scale[i]
    over_dx, over_square = over_scale / geometry.dx[i], over_scale * over_scale
    below, above = geometry.inverse_x[i] * geometry.scale_x[i], geometry.inverse_x[i + 1] * geometry.scale_x[i + 1]
    for k in range(ONE, np.uint64(over_dy.size + 1)):
        j = k - ONE
        x_part = face_conductance(below, K_behind[k], K[k]) + face_conductance(above, K[k], K_ahead[k])
        y_part = face_conductance(inverse_y[j], K[j], K[k]) + face_conductance(inverse_y[k], K[k], K[k + ONE])
        conductance[k] = over_dx * x_part + (over_square * over_dy[j]) * y_part


@part
def wall_conductances(geometry, sides, i, s):
    """Add those of walls to the conductances of row i: what the heat law gave, or the cell's own.

    A side whose wall has no temperature gives no heat.
    """
    ny, last = geometry.dy.size, geometry.dx.size - 1
    T, _, K = lines_of(s, i)
    for end in (LOW, HIGH):
        row = 0 if end == LOW else last
        if i == row:
            for j in range(ny):
                heat, wall = sides.x[end, HEAT, j], sides.x[end, TEMPERATURE, j]
                s[CONDUCTANCE, j + 1] += wall_conductance(heat, wall, T[j + 1], K[j + 1], geometry.dx[i])
        column = 0 if end == LOW else ny - 1
        heat, wall, k = sides.y[end, HEAT, i], sides.y[end, TEMPERATURE, i], column + 1
        width = geometry.dy[column] * geometry.scale[i]
        s[CONDUCTANCE, k] += wall_conductance(heat, wall, T[k], K[k], width)


@part
def wall_conductance(heat, wall, T, K, width):
    """Conductance between a wall and the cell beside it, over the cell's area."""
    if wall == 0.0:
        return 0.0
    over_width, gap = 1.0 / width, abs(wall - T)
    given = abs(heat) / gap if gap > 0.0 else 0.0
    return max(given, 2.0 * over_width * K) * over_width


@kernel(parallel=True)
def start_rates(geometry, sides, arrays):
    """Rates of conduction and cooling at the start; per row, what they and the spectral radius ask of the step."""
    work = arrays.work
    nx, bands = work.shape[1], arrays.scratch.shape[0]
    for band in prange(bands):
        s = arrays.scratch[band]
        first, stop = band * nx // bands, (band + 1) * nx // bands
        start_lines(geometry, sides, arrays, START, first, s)
        for i in range(first, stop):
            divergence_line(geometry, sides, arrays, START, i, s)
            conductance_line(geometry, i, s)
            wall_conductances(geometry, sides, i, s)
            start_row(work, i, s, arrays.sums)


@part
def start_row(work, i, s, sums):
    """Rates of row i at the start from its divergence and conductance."""
    _, roots, _ = lines_of(s, i)
    divergence, conductance = s[DIVERGENCE], s[CONDUCTANCE]
    T, inverse, cooling = work[START, i], work[INVERSE, i], work[COOLING, i]
    conducted, cooled = work[CONDUCTED, i], work[COOLED, i]
    radius, rate = work[NEXT, i], work[LAST, i]
    for j in range(np.uint64(T.size)):
        root = roots[j + ONE]
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
def stage(geometry, sides, arrays, last, mu, nu, rate, start_rate):
    """A later stage of RKL2, from the temperatures in field `last` into the other one."""
    work = arrays.work
    nx, bands = work.shape[1], arrays.scratch.shape[0]
    for band in prange(bands):
        s = arrays.scratch[band]
        first, stop = band * nx // bands, (band + 1) * nx // bands
        start_lines(geometry, sides, arrays, last, first, s)
        for i in range(first, stop):
            divergence_line(geometry, sides, arrays, last, i, s)
            stage_row(work, last, i, s, mu, nu, rate, start_rate)


@part
def stage_row(work, last, i, s, mu, nu, rate, start_rate):
    """Row i of a later stage."""
    _, roots, _ = lines_of(s, i)
    divergence = s[DIVERGENCE]
    following = LAST + NEXT - last
    T, T_next, T_start = work[last, i], work[following, i], work[START, i]
    lost, lost_next = work[last + LOST, i], work[following + LOST, i]
    conducted, cooled = work[CONDUCTED, i], work[COOLED, i]
    inverse, cooling = work[INVERSE, i], work[COOLING, i]
    rest = 1.0 - mu - nu
    for j in range(np.uint64(T.size)):
        loss = cooling[j] * T[j] * roots[j + ONE]
        change = rate * (divergence[j + ONE] * inverse[j] - loss) + start_rate * (conducted[j] - cooled[j])
        T_next[j] = mu * T[j] + nu * T_next[j] + rest * T_start[j] + change
        lost_next[j] = mu * lost[j] + nu * lost_next[j] + rate * loss + start_rate * cooled[j]


@kernel(parallel=True)
def correct(geometry, elastic_below, arrays, state, dt):
    """Cool each cell to fourth order under its mean conducted heat; put the change into energy and START."""
    for i in prange(state.shape[1]):
        correct_row(geometry, elastic_below, arrays.work, arrays.sums, state[N, i], state[E, i], i, dt)


@part
def correct_row(geometry, elastic_below, work, sums, density, energy, i, dt):
    """Row i of `correct`.

    With d the conducted heat per grain and time, and i = c T^(3/2) the loss, dT/dt = d - i; the loss over dt
    is the Taylor series of i along this trajectory. It is no good where the temperature changes by as much as
    itself, beside a wall that is suddenly hot: there RKL2's own loss stands. The share of inelastic collisions is the
    mean of those before and after.
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
        share = inelastic_share(T[j], elastic_below)
        loss *= 0.5 * (1.0 + inelastic_share(T[j] + conducted - loss, elastic_below) / share)
        change = conducted - loss
        T[j] += change
        cooling[j] *= inelastic_share(T[j], elastic_below) / share
        energy[j] += density[j] * change
        total += density[j] * loss * geometry.dy[j]
    sums[LOSS, i] = total * (geometry.scale[i] * geometry.dx[i])
