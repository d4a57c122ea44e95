"""Viscosity by super-time-stepping, where momentum is a cell's.

The velocity of a face is the mean of its two cells', and a cell has half of the force on each of its faces.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydro.fields import MX, MY, E, N
from hydro.gas import Closure
from hydro.jit import kernel, part
from hydro.mesh import Faces, Geometry, Mesh
from hydro.numerics.rkl2 import first_rate, stage_count, stage_weights
from hydro.terms.viscosity.stress import Viscous, add_wall_stress, find_viscosities, stress_force, viscous_heating
from hydro.walls.boundary import Sides

SAFETY = 1.2  # of the spectral radius


class Stages(NamedTuple):
    """Changes of momentum and energy in a step and their rates, each (3, nx, ny)."""

    first: np.ndarray  # rates at the start
    last: np.ndarray
    before: np.ndarray
    rates: np.ndarray

    @classmethod
    def of(cls, mesh: Mesh) -> Stages:
        return cls(*(np.zeros((3, *mesh.cells)) for _ in range(4)))


def advance(
    gas: Closure, factor: float, geometry: Geometry, sides: Sides, a: Viscous, velocity: Faces, stages: Stages,
    state: np.ndarray, dt: float, spared: np.ndarray,
) -> None:  # fmt: skip
    """Viscous flow of the conserved `state` (4, nx, ny) for `dt`, at frozen density: one RKL2 step.

    spared: (m, 2), cells that are left as they are.

    It acts on what changes, so that gas at rest, or moving as a whole, stays as it is to the last bit.
    """
    first, last, before, rates = stages
    last[:], before[:] = 0.0, 0.0
    find_rates(gas, factor, geometry, sides, state, last, spared, a, velocity, first)
    count = stage_count(0.5 * dt * SAFETY * spectral_radius(geometry, state[N], a))
    combine(1.0, before, 0.0, last, first_rate(count) * dt, first, 0.0, first)
    for j in range(2, count + 1):
        mu, nu, rate, start_rate = stage_weights(j, count)
        find_rates(gas, factor, geometry, sides, state, last, spared, a, velocity, rates)
        combine(mu, last, nu, before, rate * dt, rates, start_rate * dt, first)
        last, before = before, last
    state[MX:] += last


@kernel(exact=True)
def find_rates(gas, factor, geometry, sides, state, change, spared, a, velocity, rates):
    """Rates of momentum and energy of cells, (3, nx, ny), for `state` (4, nx, ny) and what has been added to it."""
    nx, ny = a.eta.shape
    u, v, T = rates[0], rates[1], rates[2]
    for i in range(nx):
        for j in range(ny):
            over = 1.0 / state[N, i, j]
            u[i, j], v[i, j] = (state[MX, i, j] + change[0, i, j]) * over, (state[MY, i, j] + change[1, i, j]) * over
            kinetic = 0.5 * (u[i, j] * u[i, j] + v[i, j] * v[i, j])
            T[i, j] = (state[E, i, j] + change[2, i, j]) * over - kinetic
    find_viscosities(gas, factor, geometry, state[N], T, a)
    for m in range(spared.shape[0]):
        spare(geometry, spared[m, 0], spared[m, 1], a)
    for i in range(nx + 1):
        here, behind, aperture = i % nx, i - 1, geometry.aperture_x[geometry.pattern_x[i]]
        for j in range(ny):
            velocity.x[i, j] = aperture[j] * (0.5 * (u[here, j] + u[behind, j]))
    for i in range(nx):
        aperture = geometry.aperture_y[geometry.pattern_y[i]]
        for j in range(ny):
            velocity.y[i, j] = aperture[j] * (0.5 * (v[i, j] + v[i, j - 1]))
        velocity.y[i, ny] = aperture[ny] * (0.5 * (v[i, 0] + v[i, ny - 1]))
    stress_force(geometry, velocity, a)
    viscous_heating(velocity, a)
    add_wall_stress(geometry, sides, a.force)
    for i in range(nx):
        for j in range(ny):
            rates[0, i, j] = 0.5 * (a.force.x[i, j] + a.force.x[i + 1, j])
            rates[1, i, j] = 0.5 * (a.force.y[i, j] + a.force.y[i, j + 1])
            rates[2, i, j] = a.power[i, j]


@part(exact=True)
def spare(geometry, i, j, a):
    """No viscosity in a cell, those beside it and its corners: no force acts on its faces, and nothing heats it."""
    nx, ny = a.eta.shape
    for di, dj in ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)):
        k = (i + di) % nx if geometry.periodic_x else min(max(i + di, 0), nx - 1)
        m = (j + dj) % ny if geometry.periodic_y else min(max(j + dj, 0), ny - 1)
        a.eta[k, m], a.zeta[k, m] = 0.0, 0.0
    for k in (i, i + 1):
        for m in (j, j + 1):
            a.corner[k, m] = 0.0
            if geometry.periodic_x and k % nx == 0:
                a.corner[nx - k, m] = 0.0
            if geometry.periodic_y and m % ny == 0:
                a.corner[k, ny - m] = 0.0
                if geometry.periodic_x and k % nx == 0:
                    a.corner[nx - k, ny - m] = 0.0


@kernel(exact=True)
def spectral_radius(geometry, density, a):
    """A bound, after `find_rates`: 4 (eta + zeta)/n (1/dx^2 + 1/dy^2), of the stiffest neighbour."""
    nx, ny = density.shape
    largest = 0.0
    for i in range(nx):
        over_x = max(geometry.inverse_x[i], geometry.inverse_x[i + 1])
        for j in range(ny):
            over_y = max(geometry.inverse_y[j], geometry.inverse_y[j + 1])
            stiffest = 0.0
            for di in range(-1, 2):
                k = (i + di) % nx if geometry.periodic_x else min(max(i + di, 0), nx - 1)
                for dj in range(-1, 2):
                    m = (j + dj) % ny if geometry.periodic_y else min(max(j + dj, 0), ny - 1)
                    stiffest = max(stiffest, a.eta[k, m] + a.zeta[k, m])
            largest = max(largest, 4.0 * stiffest * (over_x * over_x + over_y * over_y) / density[i, j])
    return largest


@kernel(exact=True)
def combine(mu, last, nu, before, rate, rates, start_rate, first):
    """before = mu last + nu before + rate rates + start_rate first, all (3, nx, ny)."""
    for q in range(before.shape[0]):
        for i in range(before.shape[1]):
            for j in range(before.shape[2]):
                change = rate * rates[q, i, j] + start_rate * first[q, i, j]
                before[q, i, j] = mu * last[q, i, j] + nu * before[q, i, j] + change
