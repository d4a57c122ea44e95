"""Viscous stress, for both integrators.

    sigma = eta (grad v + (grad v)^T) + (zeta - eta) div v,    d(nv)/dt = div sigma,    de/dt = div(sigma v)

Velocities live on the faces that they point through; stretching and its stress in the cells, shear in the corners. The
force is minus the derivative of half the dissipated power with respect to the velocities: the operator is symmetric,
what the flow loses is what cells and corners dissipate, and that is nowhere negative. A cell is given the work done on
its halves of the faces, and the heat of its own and of its quarters of the corners, so that the sum of the energies of
all cells stays, to round-off. Walls are smooth: no flow through them, no shear stress on them.

Where momentum is a cell's, the velocity of a face is the mean of its two cells', and a cell has half of the force on
each of its faces. `advance` is then RKL2, as for conduction (see `heat`). Where it is a face's, `imply` finds implicit
velocities by conjugate gradients.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydro.dynamics.heat import coefficients, stage_count
from hydro.jit import kernel

SAFETY = 1.2  # of the spectral radius
SOLVED = 1e-8  # residual of the implicit velocities against their right-hand side, root mean square
SHARE = 1e-3  # of the residual of the first guess that may stay, if that is more: little beside the error of the step
NOISE = 1e-15  # residual that is round-off, against (p n)^(1/2)
ITERATIONS = 5000

N, MX, MY, E = 0, 1, 2, 3
U_X, V_Y, BENT = 0, 1, 2  # rates of strain and stresses: along x and along y in cells, shear in corners
FIRST, LAST, BEFORE, RATES = 0, 1, 2, 3  # work of `advance`, each momentum along x and y, and energy
RESIDUAL, DIRECTION, INERTIA, SCALE = 0, 1, 2, 3  # work of `imply`, each of faces in x and in y


class Arrays(NamedTuple):
    """Work space, 208 bytes per cell. Faces and corners [i, j] are those below cell [i, j]."""

    eta: np.ndarray  # (nx, ny), shear viscosity
    zeta: np.ndarray  # (nx, ny), bulk viscosity
    corner: np.ndarray  # (nx, ny), shear viscosity of corners
    strain: np.ndarray  # (3, nx, ny)
    stress: np.ndarray  # (3, nx, ny)
    velocity: np.ndarray  # (2, nx, ny), of faces
    force: np.ndarray  # (2, nx, ny), per area, on faces
    power: np.ndarray  # (nx, ny), per area, into cells
    work: np.ndarray  # (4, 3, nx, ny)

    @classmethod
    def of(cls, mesh) -> Arrays:
        shapes = (*[mesh.cells] * 3, *[(3, *mesh.cells)] * 2, *[(2, *mesh.cells)] * 2, mesh.cells, (4, 3, *mesh.cells))
        return cls(*(np.zeros(shape) for shape in shapes))


@kernel(exact=True)
def prepare(gas, factor, geometry, density, temperature, a):
    """Viscosities of cells and corners; `factor` times those of the closure."""
    nx, ny = density.shape
    for i in range(nx):
        for j in range(ny):
            eta, zeta = gas.viscosities(density[i, j], temperature[i, j])
            a.eta[i, j], a.zeta[i, j] = factor * eta, factor * zeta
    for i in range(nx):
        for j in range(ny):
            below, above = a.eta[i - 1, j - 1] + a.eta[i - 1, j], a.eta[i, j - 1] + a.eta[i, j]
            inside = (i > 0 or geometry.periodic_x) and (j > 0 or geometry.periodic_y)
            a.corner[i, j] = 0.25 * (below + above) if inside else 0.0


@kernel(exact=True)
def exert(geometry, velocity, a):
    """Strain, stress and force for velocities (2, nx, ny) of the faces, which vanish on walls."""
    nx, ny = a.eta.shape
    u, v, strain, stress = velocity[0], velocity[1], a.strain, a.stress
    for i in range(nx):
        k, over_dx = i + 1 if i < nx - 1 else 0, 1.0 / geometry.dx[i]
        for j in range(ny):
            m = j + 1 if j < ny - 1 else 0
            u_x, v_y = (u[k, j] - u[i, j]) * over_dx, (v[i, m] - v[i, j]) / geometry.dy[j]
            u_y, v_x = (u[i, j] - u[i, j - 1]) * geometry.inverse_y[j], (v[i, j] - v[i - 1, j]) * geometry.inverse_x[i]
            expansion = (a.zeta[i, j] - a.eta[i, j]) * (u_x + v_y)
            strain[U_X, i, j], strain[V_Y, i, j], strain[BENT, i, j] = u_x, v_y, u_y + v_x
            stress[U_X, i, j] = expansion + 2.0 * a.eta[i, j] * u_x
            stress[V_Y, i, j] = expansion + 2.0 * a.eta[i, j] * v_y
            stress[BENT, i, j] = a.corner[i, j] * (u_y + v_x)
    for i in range(nx):
        k = i + 1 if i < nx - 1 else 0
        over_dx, open_x = 1.0 / geometry.dx[i], 1.0 if i > 0 or geometry.periodic_x else 0.0
        for j in range(ny):
            m, open_y = j + 1 if j < ny - 1 else 0, 1.0 if j > 0 or geometry.periodic_y else 0.0
            push_x = (stress[U_X, i, j] - stress[U_X, i - 1, j]) * geometry.inverse_x[i]
            push_y = (stress[V_Y, i, j] - stress[V_Y, i, j - 1]) * geometry.inverse_y[j]
            a.force[0, i, j] = open_x * (push_x + (stress[BENT, i, m] - stress[BENT, i, j]) / geometry.dy[j])
            a.force[1, i, j] = open_y * (push_y + (stress[BENT, k, j] - stress[BENT, i, j]) * over_dx)


@kernel(exact=True)
def supply(velocity, a):
    """Power into cells, after `exert`: work on their halves of the faces, and heat. It adds up to zero over the box."""
    nx, ny = a.eta.shape
    stress, strain, force = a.stress, a.strain, a.force
    for i in range(nx):
        k = i + 1 if i < nx - 1 else 0
        for j in range(ny):
            m = j + 1 if j < ny - 1 else 0
            in_x = velocity[0, i, j] * force[0, i, j] + velocity[0, k, j] * force[0, k, j]
            in_y = velocity[1, i, j] * force[1, i, j] + velocity[1, i, m] * force[1, i, m]
            stretched = stress[U_X, i, j] * strain[U_X, i, j] + stress[V_Y, i, j] * strain[V_Y, i, j]
            near = stress[BENT, i, j] * strain[BENT, i, j] + stress[BENT, i, m] * strain[BENT, i, m]
            far = stress[BENT, k, j] * strain[BENT, k, j] + stress[BENT, k, m] * strain[BENT, k, m]
            a.power[i, j] = 0.5 * (in_x + in_y) + (stretched + 0.25 * (near + far))


@kernel(exact=True)
def rates_of(gas, factor, geometry, state, change, a, rates):
    """Rates of momentum and energy of cells, (3, nx, ny), for `state` (4, nx, ny) and what has been added to it."""
    nx, ny = a.eta.shape
    u, v, T = rates[0], rates[1], rates[2]
    for i in range(nx):
        for j in range(ny):
            over = 1.0 / state[N, i, j]
            u[i, j], v[i, j] = (state[MX, i, j] + change[0, i, j]) * over, (state[MY, i, j] + change[1, i, j]) * over
            kinetic = 0.5 * (u[i, j] * u[i, j] + v[i, j] * v[i, j])
            T[i, j] = (state[E, i, j] + change[2, i, j]) * over - kinetic
    prepare(gas, factor, geometry, state[N], T, a)
    for i in range(nx):
        for j in range(ny):
            open_x, open_y = i > 0 or geometry.periodic_x, j > 0 or geometry.periodic_y
            a.velocity[0, i, j] = 0.5 * (u[i, j] + u[i - 1, j]) if open_x else 0.0
            a.velocity[1, i, j] = 0.5 * (v[i, j] + v[i, j - 1]) if open_y else 0.0
    exert(geometry, a.velocity, a)
    supply(a.velocity, a)
    for i in range(nx):
        k = i + 1 if i < nx - 1 else 0
        for j in range(ny):
            m = j + 1 if j < ny - 1 else 0
            rates[0, i, j] = 0.5 * (a.force[0, i, j] + a.force[0, k, j])
            rates[1, i, j] = 0.5 * (a.force[1, i, j] + a.force[1, i, m])
            rates[2, i, j] = a.power[i, j]


@kernel(exact=True)
def radius(geometry, density, a):
    """Bound of the spectral radius, after `prepare`: 4 (eta + zeta)/n (1/dx^2 + 1/dy^2), of the stiffest neighbour."""
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
                turn = rate * rates[q, i, j] + start_rate * first[q, i, j]
                before[q, i, j] = mu * last[q, i, j] + nu * before[q, i, j] + turn


@kernel(exact=True)
def advance(gas, factor, geometry, a, state, dt):
    """Viscous flow of the conserved `state` (4, nx, ny) for `dt`, at frozen density: one RKL2 step.

    It acts on what changes, so that gas at rest, or moving as a whole, stays as it is to the last bit.
    """
    first, last, before, rates = a.work[FIRST], a.work[LAST], a.work[BEFORE], a.work[RATES]
    last[:], before[:] = 0.0, 0.0
    rates_of(gas, factor, geometry, state, last, a, first)
    stages = stage_count(0.5 * dt * SAFETY * radius(geometry, state[N], a))
    unit = 4.0 / (stages * stages + stages - 2.0)
    combine(1.0, before, 0.0, last, unit * dt / 3.0, first, 0.0, first)
    for j in range(2, stages + 1):
        mu, nu, rate, start_rate = coefficients(j, unit)
        rates_of(gas, factor, geometry, state, last, a, rates)
        combine(mu, last, nu, before, rate * dt, rates, start_rate * dt, first)
        last, before = before, last
    momenta_and_energy = state[1:]
    combine(1.0, momenta_and_energy, 0.0, momenta_and_energy, 1.0, last, 0.0, last)


@kernel(exact=True)
def load(geometry, drive_x, drive_y, density, pressure, h, friction, a):
    """Inertia, diagonal and right-hand side of the implicit velocities; the latter into RESIDUAL. Zero on walls."""
    nx, ny = density.shape
    right, inertia, scale = a.work[RESIDUAL], a.work[INERTIA], a.work[SCALE]
    for i in range(nx):
        k, over_x, over_dx = i + 1 if i < nx - 1 else 0, geometry.inverse_x[i], 1.0 / geometry.dx[i]
        for j in range(ny):
            m, over_y, over_dy = j + 1 if j < ny - 1 else 0, geometry.inverse_y[j], 1.0 / geometry.dy[j]
            inertia[0, i, j] = 0.5 * (density[i, j] + density[i - 1, j]) * (1.0 + h * friction)
            inertia[1, i, j] = 0.5 * (density[i, j] + density[i, j - 1]) * (1.0 + h * friction)
            here, behind = a.eta[i, j] + a.zeta[i, j], a.eta[i - 1, j] + a.zeta[i - 1, j]
            below = a.eta[i, j - 1] + a.zeta[i, j - 1]
            normal_x = (here * over_dx + behind / geometry.dx[i - 1]) * over_x
            normal_y = (here / geometry.dy[j] + below / geometry.dy[j - 1]) * over_y
            along_y = (a.corner[i, j] * over_y + a.corner[i, m] * geometry.inverse_y[j + 1]) * over_dy
            along_x = (a.corner[i, j] * over_x + a.corner[k, j] * geometry.inverse_x[i + 1]) * over_dx
            scale[0, i, j] = inertia[0, i, j] + h * (normal_x + along_y)
            scale[1, i, j] = inertia[1, i, j] + h * (normal_y + along_x)
            push_x = h * (pressure[i, j] - pressure[i - 1, j]) * over_x
            push_y = h * (pressure[i, j] - pressure[i, j - 1]) * over_y
            right[0, i, j] = drive_x[i, j] - push_x if i > 0 or geometry.periodic_x else 0.0
            right[1, i, j] = drive_y[i, j] - push_y if j > 0 or geometry.periodic_y else 0.0


@kernel(exact=True)
def shift(share, direction, h, a):
    """Subtract from RESIDUAL what `share` of the velocities `direction` contributes, after `exert`."""
    residual, inertia = a.work[RESIDUAL], a.work[INERTIA]
    for q in range(2):
        for i in range(a.eta.shape[0]):
            for j in range(a.eta.shape[1]):
                image = inertia[q, i, j] * direction[q, i, j] - h * a.force[q, i, j]
                residual[q, i, j] -= share * image


@kernel
def products(geometry, h, a):
    """Sums over faces, weighted with their areas: residual^2/inertia, residual^2/scale, direction times its image."""
    error, size, along = 0.0, 0.0, 0.0
    for q in range(2):
        for i in range(a.eta.shape[0]):
            residual, inertia, scale = a.work[RESIDUAL, q, i], a.work[INERTIA, q, i], a.work[SCALE, q, i]
            direction, force = a.work[DIRECTION, q, i], a.force[q, i]
            width = 1.0 / geometry.inverse_x[i] if q == 0 else geometry.dx[i]
            for j in range(a.eta.shape[1]):
                area = width * (geometry.dy[j] if q == 0 else 1.0 / geometry.inverse_y[j])
                error += area * residual[j] * residual[j] / inertia[j]
                size += area * residual[j] * residual[j] / scale[j]
                along += area * direction[j] * (inertia[j] * direction[j] - h * force[j])
    return error, size, along


@kernel(exact=True)
def turn(share, a):
    """The next direction: the residual over its scale, and `share` of the last direction."""
    residual, scale, direction = a.work[RESIDUAL], a.work[SCALE], a.work[DIRECTION]
    for q in range(2):
        for i in range(a.eta.shape[0]):
            for j in range(a.eta.shape[1]):
                direction[q, i, j] = residual[q, i, j] / scale[q, i, j] + share * direction[q, i, j]


@kernel(exact=True)
def relax(geometry, h, noise, a):
    """Implicit velocities of the faces, into `velocity`, by conjugate gradients; returns the number of iterations."""
    direction = a.work[DIRECTION]
    direction[:] = 0.0
    enough = noise + SOLVED**2 * products(geometry, h, a)[0]
    exert(geometry, a.velocity, a)
    shift(1.0, a.velocity, h, a)
    (error, size, _), before = products(geometry, h, a), np.inf
    enough = max(enough, SHARE**2 * error)
    for iteration in range(ITERATIONS):
        if error <= enough:
            return iteration
        turn(size / before, a)
        before = size
        exert(geometry, direction[:2], a)
        share = before / products(geometry, h, a)[2]
        for q in range(2):
            for i in range(a.eta.shape[0]):
                for j in range(a.eta.shape[1]):
                    a.velocity[q, i, j] += share * direction[q, i, j]
        shift(share, direction, h, a)
        error, size, _ = products(geometry, h, a)
    return ITERATIONS


@kernel(exact=True)
def imply(gas, factor, geometry, pressure, ahead, h, friction, drive_x, drive_y, energy, a):
    """Viscosity of a step `h` that is implicit in the velocities, into what the pressure then acts on.

    pressure: (nx, ny), of the new time, roughly. ahead: (4, nx, ny), n, u, v, p likewise. drive_x, drive_y:
    (nx, ny), momentum of the faces before pressure, friction and viscosity act; energy: (nx, ny), of cells. The
    velocities in `a` are a first guess. Returns the number of iterations.

    The velocities are those that this pressure gives. What the new one adds to them feels no viscosity, an error of
    third order in the step (incremental pressure correction; van Kan, SIAM J. Sci. Stat. Comput. 7, 870, 1986).
    """
    nx, ny = pressure.shape
    total = 0.0
    for i in range(nx):
        for j in range(ny):
            a.power[i, j] = gas.temperature(ahead[0, i, j], ahead[3, i, j])
            total += geometry.dx[i] * geometry.dy[j] * pressure[i, j]
    prepare(gas, factor, geometry, ahead[0], a.power, a)
    load(geometry, drive_x, drive_y, ahead[0], pressure, h, friction, a)
    iterations = relax(geometry, h, NOISE**2 * total, a)
    exert(geometry, a.velocity, a)
    supply(a.velocity, a)
    inertia = a.work[INERTIA]
    for i in range(nx):
        for j in range(ny):
            energy[i, j] += h * a.power[i, j]
            push_x = h * (pressure[i, j] - pressure[i - 1, j]) * geometry.inverse_x[i]
            push_y = h * (pressure[i, j] - pressure[i, j - 1]) * geometry.inverse_y[j]
            free_x, free_y = i > 0 or geometry.periodic_x, j > 0 or geometry.periodic_y
            drive_x[i, j] = inertia[0, i, j] * a.velocity[0, i, j] + push_x if free_x else 0.0
            drive_y[i, j] = inertia[1, i, j] * a.velocity[1, i, j] + push_y if free_y else 0.0
    return iterations
