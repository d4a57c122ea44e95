"""Viscosity that is implicit in the velocities, where momentum is a face's: conjugate gradients.

The velocities are those that a pressure near the new one gives. What the new one adds to them feels no viscosity, an
error of third order in the step (incremental pressure correction; van Kan, SIAM J. Sci. Stat. Comput. 7, 870, 1986).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydro.jit import kernel, part
from hydro.mesh import Faces, Mesh
from hydro.terms.viscosity.stress import add_wall_stress, find_viscosities, stress_force

SOLVED = 1e-8  # residual of the implicit velocities against their right-hand side, root mean square
SHARE = 1e-3  # of the residual of the first guess that may stay, if that is more: little beside the error of the step
NOISE = 1e-15  # residual that is round-off, against (p n)^(1/2)
ITERATIONS = 5000
ONE = np.uint64(1)


class Gradients(NamedTuple):
    """Work of the conjugate gradients."""

    residual: Faces
    direction: Faces
    inertia: Faces
    diagonal: Faces

    @classmethod
    def of(cls, mesh: Mesh) -> Gradients:
        return cls(*(Faces.of(mesh) for _ in range(4)))


@kernel(exact=True)
def prepare(gas, factor, geometry, density, pressure, pushing, a):
    """Viscosities of the extrapolated state; returns the integral of the pressure `pushing`."""
    nx, ny = pressure.shape
    total = 0.0
    for i in range(nx):
        for j in range(ny):
            a.power[i, j] = gas.temperature(density[i, j], pressure[i, j])
            total += geometry.dx[i] * geometry.dy[j] * pushing[i, j]
    find_viscosities(gas, factor, geometry, density, a.power, a)
    return total


@kernel(exact=True)
def load(geometry, sides, momentum, density, pressure, h, drag, a, w):
    """Inertia, diagonal and right-hand side of the implicit velocities; the latter into `residual`. Zero if closed."""
    nx, ny = density.shape
    a.force.x[:] = 0.0
    a.force.y[:] = 0.0
    add_wall_stress(geometry, sides, a.force)
    for i in range(nx + 1):
        here, behind, aperture = i % nx, i - 1, geometry.aperture_x[geometry.pattern_x[i]]
        over_x, over_dx, width_behind = geometry.inverse_x[i], 1.0 / geometry.dx[here], geometry.dx[behind]
        for j in range(ny):
            inertia = 0.5 * (density[here, j] + density[behind, j]) * (1.0 + h * drag)
            stiff, stiff_behind = a.eta[here, j] + a.zeta[here, j], a.eta[behind, j] + a.zeta[behind, j]
            normal = (stiff * over_dx + stiff_behind / width_behind) * over_x
            over_dy = 1.0 / geometry.dy[j]
            shear = (a.corner[i, j] * geometry.inverse_y[j] + a.corner[i, j + 1] * geometry.inverse_y[j + 1]) * over_dy
            w.inertia.x[i, j] = inertia
            w.diagonal.x[i, j] = inertia + h * (normal + shear)
            pressed = h * (pressure[here, j] - pressure[behind, j]) * over_x
            w.residual.x[i, j] = aperture[j] * (momentum.x[i, j] - pressed + h * a.force.x[i, j])
    for i in range(nx):
        aperture, over_dx = geometry.aperture_y[geometry.pattern_y[i]], 1.0 / geometry.dx[i]
        for j in range(ny + 1):
            here, behind = j % ny, (j - 1) % ny
            over_y = geometry.inverse_y[j]
            inertia = 0.5 * (density[i, here] + density[i, behind]) * (1.0 + h * drag)
            stiff, stiff_behind = a.eta[i, here] + a.zeta[i, here], a.eta[i, behind] + a.zeta[i, behind]
            normal = (stiff / geometry.dy[here] + stiff_behind / geometry.dy[behind]) * over_y
            shear = (a.corner[i, j] * geometry.inverse_x[i] + a.corner[i + 1, j] * geometry.inverse_x[i + 1]) * over_dx
            w.inertia.y[i, j] = inertia
            w.diagonal.y[i, j] = inertia + h * (normal + shear)
            pressed = h * (pressure[i, here] - pressure[i, behind]) * over_y
            w.residual.y[i, j] = aperture[j] * (momentum.y[i, j] - pressed + h * a.force.y[i, j])


@kernel(exact=True)
def relax(geometry, h, noise, velocity, a, w):
    """Implicit velocities of the faces, into `velocity`; returns the number of iterations."""
    w.direction.x[:] = 0.0
    w.direction.y[:] = 0.0
    enough = noise + SOLVED**2 * products(geometry, h, a, w)[0]
    stress_force(geometry, velocity, a)
    subtract_image(1.0, velocity, h, a, w)
    (error, size, _), before = products(geometry, h, a, w), np.inf
    enough = max(enough, SHARE**2 * error)
    for iteration in range(ITERATIONS):
        if error <= enough:
            return iteration
        next_direction(size / before, w)
        before = size
        stress_force(geometry, w.direction, a)
        share = before / products(geometry, h, a, w)[2]
        add_faces(velocity.x, w.direction.x, share)
        add_faces(velocity.y, w.direction.y, share)
        subtract_image(share, w.direction, h, a, w)
        error, size, _ = products(geometry, h, a, w)
    return ITERATIONS


@part(exact=True)
def add_faces(field, direction, share):
    """field += share direction."""
    for i in range(field.shape[0]):
        for j in range(field.shape[1]):
            field[i, j] += share * direction[i, j]


@part(exact=True)
def subtract_image(share, direction, h, a, w):
    """Subtract from the residual what `share` of the velocities `direction` contributes, after `stress_force`."""
    subtract_faces(share, direction.x, h, a.force.x, w.inertia.x, w.residual.x)
    subtract_faces(share, direction.y, h, a.force.y, w.inertia.y, w.residual.y)


@part(exact=True)
def subtract_faces(share, direction, h, force, inertia, residual):
    """The same for the faces of one direction."""
    for i in range(residual.shape[0]):
        for j in range(residual.shape[1]):
            image = inertia[i, j] * direction[i, j] - h * force[i, j]
            residual[i, j] -= share * image


@kernel
def products(geometry, h, a, w):
    """Sums over faces, weighted with their areas: residual^2/inertia, residual^2/diagonal, direction times its image.

    The last faces are not counted: they are closed, or the first ones again.
    """
    error, size, along = 0.0, 0.0, 0.0
    nx, ny = a.eta.shape
    for i in range(nx):
        residual, inertia, diagonal = w.residual.x[i], w.inertia.x[i], w.diagonal.x[i]
        direction, force, width = w.direction.x[i], a.force.x[i], 1.0 / geometry.inverse_x[i]
        for j in range(ny):
            area = width * geometry.dy[j]
            error += area * residual[j] * residual[j] / inertia[j]
            size += area * residual[j] * residual[j] / diagonal[j]
            along += area * direction[j] * (inertia[j] * direction[j] - h * force[j])
    for i in range(nx):
        residual, inertia, diagonal = w.residual.y[i], w.inertia.y[i], w.diagonal.y[i]
        direction, force = w.direction.y[i], a.force.y[i]
        for j in range(ny):
            area = geometry.dx[i] / geometry.inverse_y[j]
            error += area * residual[j] * residual[j] / inertia[j]
            size += area * residual[j] * residual[j] / diagonal[j]
            along += area * direction[j] * (inertia[j] * direction[j] - h * force[j])
    return error, size, along


@part(exact=True)
def next_direction(share, w):
    """The next direction: the residual over its diagonal, and `share` of the last direction."""
    turn_faces(share, w.residual.x, w.diagonal.x, w.direction.x)
    turn_faces(share, w.residual.y, w.diagonal.y, w.direction.y)


@part(exact=True)
def turn_faces(share, residual, diagonal, direction):
    """The same for the faces of one direction."""
    for i in range(direction.shape[0]):
        for j in range(direction.shape[1]):
            direction[i, j] = residual[i, j] / diagonal[i, j] + share * direction[i, j]


@kernel(exact=True)
def hand_over(geometry, pressure, h, velocity, a, w, momentum, energy):
    """Momentum of the faces before pressure and friction act, from their velocities; the viscous power into cells."""
    nx, ny = pressure.shape
    for i in range(nx):
        for j in range(ny):
            energy[i, j] += h * a.power[i, j]
    for i in range(nx + 1):
        here, behind, aperture = i % nx, i - 1, geometry.aperture_x[geometry.pattern_x[i]]
        for j in range(ny):
            pressed = h * (pressure[here, j] - pressure[behind, j]) * geometry.inverse_x[i]
            momentum.x[i, j] = aperture[j] * (w.inertia.x[i, j] * velocity.x[i, j] + pressed)
    for i in range(nx):
        aperture = geometry.aperture_y[geometry.pattern_y[i]]
        for j in range(ny + 1):
            pressed = h * (pressure[i, j % ny] - pressure[i, (j - 1) % ny]) * geometry.inverse_y[j]
            momentum.y[i, j] = aperture[j] * (w.inertia.y[i, j] * velocity.y[i, j] + pressed)
