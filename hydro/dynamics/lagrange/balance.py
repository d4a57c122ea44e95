"""What is missing in the balances of mass and energy of every cell, for a pressure and a temperature."""

from __future__ import annotations

import numpy as np

from hydro.dynamics.lagrange.workspace import (
    ALONG,
    CELL_MOMENTUM,
    ENERGY,
    ENERGY_LINE,
    EVEN,
    HEAT_LINE,
    MASS,
    MASS_LINE,
    MOMENTUM_LINE,
    ODD,
)
from hydro.fields import E, N
from hydro.gas.conduction import conducted_heat
from hydro.gas.elastic import inelastic_share
from hydro.jit import kernel, part
from hydro.walls.boundary import FLOW, HEAT, HIGH, LOW

ONE = np.uint64(1)


@kernel(exact=True)
def find_closures(gas, elastic_below, pressure, temperature, work):
    """Density, conductivity and cooling of all cells."""
    for i in range(pressure.shape[0]):
        closure_row(gas, elastic_below, pressure[i], temperature[i], work.density[i], work.kappa[i], work.cooling[i])


@part(exact=True)
def closure_row(gas, elastic_below, pressure, temperature, density, kappa, cooling):
    """One row of cells."""
    for j in range(np.uint64(pressure.size)):
        n = gas.density(pressure[j], temperature[j])
        root = np.sqrt(temperature[j])
        density[j] = n
        kappa[j] = gas.conductivity_coefficient(n) * root
        cooling[j] = gas.cooling_coefficient(n) * temperature[j] * root * inelastic_share(temperature[j], elastic_below)


@kernel(exact=True)
def balance(geometry, sides, P, T, h, drag, work, right):
    """What is missing in the balances of every cell, into `right` (nx, 2, ny), after `find_closures` and the walls."""
    slow = 1.0 / (1.0 + h * drag)
    for i in range(P.shape[0]):
        low, high = flux_lines(geometry, sides, P, T, h, slow, work, i)
        cell_momenta(geometry, work, low, high, i)
        balance_row(geometry, T[i], h, drag, work, low, high, i, right[i])


@part(exact=True)
def flux_lines(geometry, sides, P, T, h, slow, work, i):
    """What crosses the faces of row i, after those of row i-1; returns the places of the lower and upper lines."""
    low, high = (EVEN, ODD) if i % 2 == 0 else (ODD, EVEN)
    if i == 0:
        flux_across(geometry, P, T, h, slow, work, 0, low)
        side_across(geometry, sides.x[LOW], 0, -1.0, work, low)
    flux_across(geometry, P, T, h, slow, work, i + 1, high)
    if i == P.shape[0] - 1:
        side_across(geometry, sides.x[HIGH], i + 1, 1.0, work, high)
    flux_along(geometry, P[i], T[i], h, slow, work, i)
    side_along(geometry, sides.y, work, i)
    return low, high


@part(exact=True)
def flux_across(geometry, P, T, h, slow, work, i, side):
    """Momentum, mass, energy and heat through the faces in x below row i, into the lines from `side` on."""
    here, behind, lines = i % P.shape[0], i - 1, work.lines
    momentum, mass = lines[side + MOMENTUM_LINE], lines[side + MASS_LINE]
    energy, heat = lines[side + ENERGY_LINE], lines[side + HEAT_LINE]
    P_low, P_high, T_low, T_high = P[behind], P[here], T[behind], T[here]
    kappa_low, kappa_high, before = work.kappa[behind], work.kappa[here], work.momentum.x[i]
    mass_along, energy_along = work.carried_x[MASS, i], work.carried_x[ENERGY, i]
    dy, aperture = geometry.dy, geometry.aperture_x[geometry.pattern_x[i]]
    inverse, weight = geometry.inverse_x[i], geometry.inverse_x[i] * geometry.scale_x[i]
    for j in range(np.uint64(dy.size)):
        pushed = aperture[j] * (slow * (before[j] - h * (P_high[j] - P_low[j]) * inverse))
        momentum[j] = pushed
        mass[j] = mass_along[j] * pushed
        energy[j] = energy_along[j] * pushed
        heat[j] = aperture[j] * conducted_heat(weight * dy[j], kappa_low[j], kappa_high[j], T_low[j], T_high[j])


@part(exact=True)
def side_across(geometry, side, i, toward, work, place):
    """Add what a side in x does to the lines of its faces; `toward` is the sign of what goes to the gas."""
    momentum, mass = work.lines[place + MOMENTUM_LINE], work.lines[place + MASS_LINE]
    energy, heat = work.lines[place + ENERGY_LINE], work.lines[place + HEAT_LINE]
    for j in range(np.uint64(geometry.dy.size)):
        flow = side[FLOW, j]
        momentum[j] += flow
        mass[j] += work.carried_x[MASS, i, j] * flow
        energy[j] += work.carried_x[ENERGY, i, j] * flow
        heat[j] += toward * side[HEAT, j] * (geometry.scale_x[i] * geometry.dy[j])


@part(exact=True)
def flux_along(geometry, P, T, h, slow, work, i):
    """Momentum, mass, energy and heat through the faces in y of row i."""
    lines, last = work.lines, P.size - 1
    momentum, mass, energy, heat = lines[ALONG], lines[ALONG + 1], lines[ALONG + 2], lines[ALONG + 3]
    before, kappa, aperture = work.momentum.y[i], work.kappa[i], geometry.aperture_y[geometry.pattern_y[i]]
    mass_along, energy_along = work.carried_y[MASS, i], work.carried_y[ENERGY, i]
    over_scale = 1.0 / geometry.scale[i]
    inverse, width = geometry.inverse_y, geometry.dx[i] * over_scale
    for j in range(ONE, np.uint64(P.size)):
        k = j - ONE
        pushed = aperture[j] * (slow * (before[j] - h * (P[j] - P[k]) * (inverse[j] * over_scale)))
        momentum[j] = pushed
        mass[j] = mass_along[j] * pushed
        energy[j] = energy_along[j] * pushed
        heat[j] = aperture[j] * conducted_heat(inverse[j] * width, kappa[k], kappa[j], T[k], T[j])
    for j in (0, last + 1):
        pushed = aperture[j] * (slow * (before[j] - h * (P[0] - P[last]) * (inverse[j] * over_scale)))
        momentum[j] = pushed
        mass[j], energy[j] = mass_along[j] * pushed, energy_along[j] * pushed
        heat[j] = aperture[j] * conducted_heat(inverse[j] * width, kappa[last], kappa[0], T[last], T[0])


@part(exact=True)
def side_along(geometry, sides, work, i):
    """Add what the sides in y do to the ends of the lines of row i."""
    lines = work.lines
    for end, j, toward in ((LOW, 0, -1.0), (HIGH, geometry.dy.size, 1.0)):
        flow = sides[end, FLOW, i]
        lines[ALONG + MOMENTUM_LINE, j] += flow
        lines[ALONG + MASS_LINE, j] += work.carried_y[MASS, i, j] * flow
        lines[ALONG + ENERGY_LINE, j] += work.carried_y[ENERGY, i, j] * flow
        lines[ALONG + HEAT_LINE, j] += toward * sides[end, HEAT, i] * geometry.dx[i]


@part(exact=True)
def cell_momenta(geometry, work, low, high, i):
    """Momentum of a row of cells after pressure and drag have acted, into two lines: the mean of its faces'.

    From the first violent cell of a run on, faces share theirs in proportion to density (see `shocks`).
    """
    lines = work.lines
    below, above, along = lines[low], lines[high], lines[ALONG]
    in_x, in_y = lines[CELL_MOMENTUM], lines[CELL_MOMENTUM + 1]
    if work.shared[0]:
        share_across(geometry, work.density, below, above, i, in_x)
        share_along(geometry, work.density[i], along, in_y)
        return
    for j in range(np.uint64(work.density.shape[1])):
        in_x[j] = 0.5 * (below[j] + above[j])
        in_y[j] = 0.5 * (along[j] + along[j + ONE])


@part(exact=True)
def share_across(geometry, density, below, above, i, out):
    """Momentum along x of row i, from its shares of the faces below and above; the shares of a face add up to one."""
    last = density.shape[0] - 1
    behind = density[i - 1 if i > 0 else (last if geometry.periodic_x else 0)]
    ahead = density[i + 1 if i < last else (0 if geometry.periodic_x else last)]
    for j in range(density.shape[1]):
        n = density[i, j]
        out[j] = n * (below[j] / (n + behind[j]) + above[j] / (n + ahead[j]))


@part(exact=True)
def share_along(geometry, density, along, out):
    """The same along y."""
    last = density.size - 1
    for j in range(density.size):
        below = density[j - 1 if j > 0 else (last if geometry.periodic_y else 0)]
        above = density[j + 1 if j < last else (0 if geometry.periodic_y else last)]
        n = density[j]
        out[j] = n * (along[j] / (n + below) + along[j + 1] / (n + above))


@part(exact=True)
def balance_row(geometry, T, h, drag, work, low, high, i, right):
    """Row i, into `right` (2, ny), from the lines of its faces at `low` and `high`."""
    lines, density, cooling = work.lines, work.density[i], work.cooling[i]
    mass_l, energy_l, heat_l = lines[low + MASS_LINE], lines[low + ENERGY_LINE], lines[low + HEAT_LINE]
    mass_h, energy_h, heat_h = lines[high + MASS_LINE], lines[high + ENERGY_LINE], lines[high + HEAT_LINE]
    mass_y, energy_y, heat_y = lines[ALONG + MASS_LINE], lines[ALONG + ENERGY_LINE], lines[ALONG + HEAT_LINE]
    in_x, in_y, base_n, base_e = lines[CELL_MOMENTUM], lines[CELL_MOMENTUM + 1], work.base[N, i], work.base[E, i]
    width, dy, right_n, right_e = geometry.scale[i] * geometry.dx[i], geometry.dy, right[0], right[1]
    for j in range(np.uint64(T.size)):
        area = width * dy[j]
        mass = (mass_h[j] - mass_l[j]) + (mass_y[j + ONE] - mass_y[j])
        energy = (energy_h[j] - energy_l[j]) + (energy_y[j + ONE] - energy_y[j])
        heat = (heat_h[j] - heat_l[j]) + (heat_y[j + ONE] - heat_y[j])
        n = density[j]
        kinetic = 0.5 * (in_x[j] * in_x[j] + in_y[j] * in_y[j]) / n
        right_n[j] = area * (base_n[j] - n) - h * mass
        stored = n * T[j] + kinetic - base_e[j]
        right_e[j] = h * (heat - energy) - area * (stored + h * (cooling[j] + 2.0 * drag * kinetic))
