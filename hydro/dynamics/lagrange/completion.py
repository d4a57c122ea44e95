"""The new state from pressure and temperature."""

from __future__ import annotations

import numpy as np

from hydro.dynamics.lagrange.balance import cell_momenta, flux_lines
from hydro.dynamics.lagrange.workspace import ALONG, CELL_MOMENTUM, ENERGY_LINE, MASS_LINE
from hydro.fields import MX, MY, E, N
from hydro.jit import kernel, part


@kernel
def complete(geometry, sides, P, T, h, drag, power, added, work, state, momentum):
    """The new state (4, nx, ny), after `find_closures` and the walls, and the momenta of the faces, into `momentum`.

    power: the heat of the walls. added: energy that cold cells get beside. Returns the power that comes through the
    sides, with gas or without, and those lost in collisions and by drag. The iteration leaves a little of the balances;
    a common factor on density, and one on energy, makes up for it: mass and the books of energy are exact.
    """
    slow, lines = 1.0 / (1.0 + h * drag), work.lines
    nx, ny = P.shape
    mass, energy, base_mass, base_energy, lost, dragged = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    mass_in, energy_in = 0.0, 0.0
    for i in range(nx):
        low, high = flux_lines(geometry, sides, P, T, h, slow, work, i)
        mass_in += lines[ALONG + MASS_LINE, 0] - lines[ALONG + MASS_LINE, ny]
        energy_in += lines[ALONG + ENERGY_LINE, 0] - lines[ALONG + ENERGY_LINE, ny]
        if i == 0:
            mass_in += total(lines[low + MASS_LINE, :ny])
            energy_in += total(lines[low + ENERGY_LINE, :ny])
        if i == nx - 1:
            mass_in -= total(lines[high + MASS_LINE, :ny])
            energy_in -= total(lines[high + ENERGY_LINE, :ny])
        cell_momenta(geometry, work, low, high, i)
        state_row(work.density[i], T[i], lines, state[N, i], state[MX, i], state[MY, i], state[E, i])
        sums = sums_of_row(
            state[N, i], state[MX, i], state[MY, i], state[E, i], work.cooling[i], work.base[N, i], work.base[E, i],
            geometry.dy, drag,
        )  # fmt: skip
        width = geometry.scale[i] * geometry.dx[i]
        mass, energy = mass + width * sums[0], energy + width * sums[1]
        base_mass, base_energy = base_mass + width * sums[2], base_energy + width * sums[3]
        lost, dragged = lost + width * sums[4], dragged + width * sums[5]
        momentum.x[i] = lines[low, :ny]
        momentum.y[i] = lines[ALONG, : ny + 1]
        if i == nx - 1:
            momentum.x[nx] = lines[high, :ny]
    given = power + energy_in
    state[N] *= (base_mass + h * mass_in) / mass
    state[E] *= (base_energy + h * (given - lost - dragged) + added) / energy
    return given, lost, dragged


@part
def total(values):
    """Sum of a row."""
    result = 0.0
    for value in values:
        result += value
    return result


@part(exact=True)
def state_row(density, T, lines, new_n, new_x, new_y, new_e):
    """The new state of one row of cells."""
    in_x, in_y = lines[CELL_MOMENTUM], lines[CELL_MOMENTUM + 1]
    for j in range(np.uint64(density.size)):
        n = density[j]
        kinetic = 0.5 * (in_x[j] * in_x[j] + in_y[j] * in_y[j]) / n
        new_n[j], new_x[j], new_y[j], new_e[j] = n, in_x[j], in_y[j], n * T[j] + kinetic


@part
def sums_of_row(density, momentum_x, momentum_y, energy, cooling, base_n, base_e, dy, drag):
    """Of one row, per width: its mass, energy, those of the base, powers of collisions and drag."""
    mass, total, base_mass, base_energy, lost, dragged = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(np.uint64(density.size)):
        mass += dy[j] * density[j]
        total += dy[j] * energy[j]
        base_mass += dy[j] * base_n[j]
        base_energy += dy[j] * base_e[j]
        lost += dy[j] * cooling[j]
        twice_kinetic = (momentum_x[j] * momentum_x[j] + momentum_y[j] * momentum_y[j]) / density[j]
        dragged += dy[j] * drag * twice_kinetic
    return mass, total, base_mass, base_energy, lost, dragged
