"""Derivatives of the balances, for `multigrid`: local terms, couplings across faces, stencils."""

from __future__ import annotations

import numpy as np

from hydro.dynamics import multigrid
from hydro.dynamics.lagrange.workspace import ENERGY, MASS
from hydro.gas.conduction import conducted_slope, face_conductance
from hydro.gas.elastic import inelastic_share, inelastic_share_slope
from hydro.jit import kernel, part
from hydro.walls.boundary import HEAT_N, HEAT_T, HIGH, LOW

ZERO, ONE = np.uint64(0), np.uint64(1)


@kernel(exact=True)
def find_jacobian(gas, elastic_below, geometry, sides, T, h, drag, work, equations):
    """Local terms, couplings and stencils of the balances, after `balance` and the walls' slopes."""
    nx = T.shape[0]
    push = h * h / (1.0 + h * drag)
    for i in range(nx):
        local_row(gas, elastic_below, geometry, T[i], h, work, equations.local[i], i)
    couple_sides(gas, geometry, sides, T, h, work, equations.local)
    for i in range(nx):
        couple_across(geometry, T[i - 1], T[i], work, push, h, equations.faces_x[i], i)
        couple_along(geometry, T[i], work, push, h, equations.faces_y[i], i)
        if i > 0:
            multigrid.build_row(equations, i - 1)
    multigrid.build_row(equations, nx - 1)


@part(exact=True)
def local_row(gas, elastic_below, geometry, T, h, work, local, i):
    """Local terms (4, ny) of row i, and the slopes of its conductivities in P and in T."""
    width, dy, density = geometry.scale[i] * geometry.dx[i], geometry.dy, work.density[i]
    l11, l12, l21, l22 = local[0], local[1], local[2], local[3]
    kappa_P, kappa_T = work.kappa_slopes[0, i], work.kappa_slopes[1, i]
    for j in range(np.uint64(density.size)):
        area, n, here = width * dy[j], density[j], T[j]
        n_P, n_T = gas.density_slopes(n, here)
        i_n, i_T = gas.cooling_slopes(n, here)
        share = inelastic_share(here, elastic_below)
        i_n, i_T = share * i_n, share * i_T + gas.cooling(n, here) * inelastic_share_slope(here, elastic_below)
        k_n, k_T = gas.conductivity_slopes(n, here)
        l11[j], l12[j] = area * n_P, area * n_T
        l21[j] = area * (n_P * here + h * i_n * n_P)
        l22[j] = area * (n + n_T * here + h * (i_n * n_T + i_T))
        kappa_P[j], kappa_T[j] = k_n * n_P, k_T + k_n * n_T


@part(exact=True)
def couple_sides(gas, geometry, sides, T, h, work, local):
    """The slopes of the walls' heat, into the local terms of the cells beside them."""
    nx, ny = T.shape
    for end, i, face in ((LOW, 0, 0), (HIGH, nx - 1, nx)):
        for j in range(ny):
            length = geometry.scale_x[face] * geometry.dy[j]
            couple_side(gas, work.density[i, j], T[i, j], h * length, sides.x[end], j, local, i, j)
    for end, j in ((LOW, 0), (HIGH, ny - 1)):
        for i in range(nx):
            couple_side(gas, work.density[i, j], T[i, j], h * geometry.dx[i], sides.y[end], i, local, i, j)


@part(exact=True)
def couple_side(gas, n, T, share, side, k, local, i, j):
    """The same of one face; k is its place along the side."""
    n_P, n_T = gas.density_slopes(n, T)
    local[i, 2, j] -= share * side[HEAT_N, k] * n_P
    local[i, 3, j] -= share * (side[HEAT_T, k] + side[HEAT_N, k] * n_T)


@part(exact=True)
def couple_across(geometry, Ta, Tb, work, push, h, faces, i):
    """Couplings (COUPLINGS, ny) across the faces in x below row i; Ta, Tb: temperatures of row i-1 and row i."""
    mass, energy_p, energy_t = faces[multigrid.MASS], faces[multigrid.ENERGY_P], faces[multigrid.ENERGY_T]
    drift_pa, drift_pb = faces[multigrid.DRIFT_PA], faces[multigrid.DRIFT_PB]
    drift_ta, drift_tb = faces[multigrid.DRIFT_TA], faces[multigrid.DRIFT_TB]
    ka, kb, slopes = work.kappa[i - 1], work.kappa[i], work.kappa_slopes
    ka_P, kb_P, ka_T, kb_T = slopes[0, i - 1], slopes[0, i], slopes[1, i - 1], slopes[1, i]
    mass_along, energy_along = work.carried_x[MASS, i], work.carried_x[ENERGY, i]
    dy, aperture = geometry.dy, geometry.aperture_x[geometry.pattern_x[i]]
    near, weight = push * geometry.inverse_x[i], h * geometry.inverse_x[i] * geometry.scale_x[i]
    for j in range(np.uint64(Ta.size)):
        pushed = near * aperture[j]
        mass[j], energy_p[j] = pushed * mass_along[j], pushed * energy_along[j]
        share = weight * dy[j] * aperture[j]
        lever = conducted_slope(share, Ta[j], Tb[j])
        energy_t[j] = face_conductance(share, ka[j], kb[j])
        drift_pa[j], drift_pb[j] = lever * ka_P[j], lever * kb_P[j]
        drift_ta[j], drift_tb[j] = lever * ka_T[j], lever * kb_T[j]


@part(exact=True)
def couple_along(geometry, T, work, push, h, faces, i):
    """Couplings (COUPLINGS, ny) across the faces in y of row i."""
    mass, energy_p, energy_t = faces[multigrid.MASS], faces[multigrid.ENERGY_P], faces[multigrid.ENERGY_T]
    drift_pa, drift_pb = faces[multigrid.DRIFT_PA], faces[multigrid.DRIFT_PB]
    drift_ta, drift_tb = faces[multigrid.DRIFT_TA], faces[multigrid.DRIFT_TB]
    kappa, kappa_P, kappa_T = work.kappa[i], work.kappa_slopes[0, i], work.kappa_slopes[1, i]
    mass_along, energy_along = work.carried_y[MASS, i], work.carried_y[ENERGY, i]
    over_scale, aperture = 1.0 / geometry.scale[i], geometry.aperture_y[geometry.pattern_y[i]]
    inverse, width, last = geometry.inverse_y, h * geometry.dx[i] * over_scale, np.uint64(T.size) - ONE
    for j in range(last + ONE):
        k = j - ONE if j > ZERO else last
        pushed = push * (inverse[j] * over_scale) * aperture[j]
        mass[j], energy_p[j] = pushed * mass_along[j], pushed * energy_along[j]
        share = width * inverse[j] * aperture[j]
        lever = conducted_slope(share, T[k], T[j])
        energy_t[j] = face_conductance(share, kappa[k], kappa[j])
        drift_pa[j], drift_pb[j] = lever * kappa_P[k], lever * kappa_P[j]
        drift_ta[j], drift_tb[j] = lever * kappa_T[k], lever * kappa_T[j]


@kernel(exact=True)
def correct(change, P, T):
    """Change the unknowns by what the cycle suggests, (nx, 2, ny + 2); returns its largest relative change.

    No unknown changes by more than half.
    """
    largest = 0.0
    for i in range(P.shape[0]):
        for q, unknown in enumerate((P, T)):
            wanted, values = change[i, q], unknown[i]
            for j in range(np.uint64(values.size)):
                size = abs(wanted[j + ONE] / values[j])
                largest = largest if size <= largest else size
    share = min(1.0, 0.5 / largest) if largest > 0.0 else 1.0
    for i in range(P.shape[0]):
        for q, unknown in enumerate((P, T)):
            wanted, values = change[i, q], unknown[i]
            for j in range(np.uint64(values.size)):
                values[j] += share * wanted[j + ONE]
    return largest
