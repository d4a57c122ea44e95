"""Viscous stress, for both integrators.

    sigma = eta (grad v + (grad v)^T) + (zeta - eta) div v,    d(nv)/dt = div sigma,    de/dt = div(sigma v)

Velocities live on the faces that they point through; stretching and its stress in the cells, shear in the corners. The
force is minus the derivative of half the dissipated power with respect to the velocities: the operator is symmetric,
what the flow loses is what cells and corners dissipate, and that is nowhere negative. A cell is given the work done on
its halves of the faces, and the heat of its own and of its quarters of the corners, so that the sum of the energies of
all cells stays, to round-off. No gas flows through closed faces, and the shear stress on corners beside them is that of
the side. Strains are those of rectilinear coordinates: a scale factor other than one would add terms.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydro.jit import kernel, part
from hydro.mesh import Faces, Mesh
from hydro.walls.boundary import HIGH, LOW, STRESS

ALONG_X, ALONG_Y = 0, 1  # stretching and its stress
ONE = np.uint64(1)


class Viscous(NamedTuple):
    """Viscosities, rates of strain, stresses and what they do, on a mesh of (nx, ny) cells."""

    eta: np.ndarray  # (nx, ny), shear viscosity
    zeta: np.ndarray  # (nx, ny), bulk viscosity
    corner: np.ndarray  # (nx+1, ny+1), shear viscosity of corners
    stretching: np.ndarray  # (2, nx, ny)
    normal_stress: np.ndarray  # (2, nx, ny)
    shear_rate: np.ndarray  # (nx+1, ny+1)
    shear_stress: np.ndarray  # (nx+1, ny+1)
    force: Faces  # per area
    power: np.ndarray  # (nx, ny), per area, into cells
    heating: np.ndarray  # (nx, ny), the heat in it

    @classmethod
    def of(cls, mesh: Mesh) -> Viscous:
        nx, ny = mesh.cells
        cells, corners = (nx, ny), (nx + 1, ny + 1)
        return cls(
            np.zeros(cells), np.zeros(cells), np.zeros(corners), np.zeros((2, *cells)), np.zeros((2, *cells)),
            np.zeros(corners), np.zeros(corners), Faces.of(mesh), np.zeros(cells), np.zeros(cells),
        )  # fmt: skip


@kernel(exact=True)
def find_viscosities(gas, factor, geometry, density, temperature, a):
    """Viscosities of cells and corners; `factor` times those of the closure. Corners beside closed faces have none."""
    nx, ny = density.shape
    for i in range(nx):
        for j in range(ny):
            eta, zeta = gas.viscosities(density[i, j], temperature[i, j])
            a.eta[i, j], a.zeta[i, j] = factor * eta, factor * zeta
    for i in range(nx + 1):
        here, behind = i % nx, i - 1
        across = geometry.aperture_x[geometry.pattern_x[i]]
        along_behind = geometry.aperture_y[geometry.pattern_y[behind]]
        along = geometry.aperture_y[geometry.pattern_y[here]]
        corner_row(a.eta[behind], a.eta[here], across, along_behind, along, a.corner[i])


@part(exact=True)
def corner_row(eta_behind, eta, across, along_behind, along, corner):
    """Viscosities of a row of corners between two rows of cells: means of four, where the four faces are open."""
    last = eta.size - 1
    for j in range(ONE, np.uint64(eta.size)):
        k = j - ONE
        below, above = eta_behind[k] + eta_behind[j], eta[k] + eta[j]
        corner[j] = 0.25 * (below + above) * (across[k] * across[j] * (along_behind[j] * along[j]))
    below, above = eta_behind[last] + eta_behind[0], eta[last] + eta[0]
    for j in (0, last + 1):
        corner[j] = 0.25 * (below + above) * (across[last] * across[0] * (along_behind[j] * along[j]))


@kernel(exact=True)
def stress_force(geometry, velocity, a):
    """Strain, stress and force for velocities of the faces, which vanish on closed ones."""
    nx = a.eta.shape[0]
    u, v, normal, shear = velocity.x, velocity.y, a.normal_stress, a.shear_stress
    for i in range(nx):
        stretch_row(u[i], u[i + 1], v[i], geometry.dx[i], geometry.dy, a.eta[i], a.zeta[i], a.stretching, normal, i)
    for i in range(nx + 1):
        shear_row(
            u[i], v[i - 1], v[i % nx], geometry.inverse_x[i], geometry.inverse_y, a.corner[i], a.shear_rate[i], shear[i]
        )
    for i in range(nx + 1):
        force_across(
            normal[ALONG_X, i - 1], normal[ALONG_X, i % nx], shear[i], geometry.inverse_x[i], geometry.dy,
            geometry.aperture_x[geometry.pattern_x[i]], a.force.x[i],
        )  # fmt: skip
    for i in range(nx):
        force_along(
            normal[ALONG_Y, i], shear[i], shear[i + 1], geometry.dx[i], geometry.inverse_y,
            geometry.aperture_y[geometry.pattern_y[i]], a.force.y[i],
        )  # fmt: skip


@part(exact=True)
def stretch_row(u, u_ahead, v, width, dy, eta, zeta, stretching, normal, i):
    """Stretching of a row of cells and the stress of it."""
    over_dx = 1.0 / width
    in_x, in_y, stress_x, stress_y = (
        stretching[ALONG_X, i],
        stretching[ALONG_Y, i],
        normal[ALONG_X, i],
        normal[ALONG_Y, i],
    )
    for j in range(np.uint64(eta.size)):
        u_x, v_y = (u_ahead[j] - u[j]) * over_dx, (v[j + ONE] - v[j]) / dy[j]
        expansion = (zeta[j] - eta[j]) * (u_x + v_y)
        in_x[j], in_y[j] = u_x, v_y
        stress_x[j], stress_y[j] = expansion + 2.0 * eta[j] * u_x, expansion + 2.0 * eta[j] * v_y


@part(exact=True)
def shear_row(u, v_behind, v, inverse_x, inverse_y, corner, rate, stress):
    """Shear of a row of corners, between two rows of cells, and the stress of it."""
    last = u.size - 1
    for j in range(ONE, np.uint64(u.size)):
        u_y, v_x = (u[j] - u[j - ONE]) * inverse_y[j], (v[j] - v_behind[j]) * inverse_x
        rate[j] = u_y + v_x
        stress[j] = corner[j] * (u_y + v_x)
    for j in (0, last + 1):
        u_y, v_x = (u[0] - u[last]) * inverse_y[j], (v[j] - v_behind[j]) * inverse_x
        rate[j] = u_y + v_x
        stress[j] = corner[j] * (u_y + v_x)


@part(exact=True)
def force_across(normal_behind, normal, shear, inverse_x, dy, aperture, force):
    """Force on a row of faces in x."""
    for j in range(np.uint64(force.size)):
        push = (normal[j] - normal_behind[j]) * inverse_x
        force[j] = aperture[j] * (push + (shear[j + ONE] - shear[j]) / dy[j])


@part(exact=True)
def force_along(normal, shear, shear_ahead, width, inverse_y, aperture, force):
    """Force on the faces in y of a row of cells."""
    last, over_dx = normal.size - 1, 1.0 / width
    for j in range(ONE, np.uint64(normal.size)):
        push = (normal[j] - normal[j - ONE]) * inverse_y[j]
        force[j] = aperture[j] * (push + (shear_ahead[j] - shear[j]) * over_dx)
    for j in (0, last + 1):
        push = (normal[0] - normal[last]) * inverse_y[j]
        force[j] = aperture[j] * (push + (shear_ahead[j] - shear[j]) * over_dx)


@kernel(exact=True)
def add_wall_stress(geometry, sides, force):
    """Add to the force the shear stress of the sides; nothing where they are periodic.

    Walls at rest do no work: what the flow loses to their stress stays in the cells, as heat.
    """
    nx, ny = geometry.dx.size, geometry.dy.size
    for j in range(1, ny):
        force.y[0, j] += geometry.aperture_y[geometry.pattern_y[0]][j] * sides.x[LOW, STRESS, j] / geometry.dx[0]
        force.y[nx - 1, j] += (
            geometry.aperture_y[geometry.pattern_y[nx - 1]][j] * sides.x[HIGH, STRESS, j] / geometry.dx[nx - 1]
        )
    for i in range(1, nx):
        force.x[i, 0] += geometry.aperture_x[geometry.pattern_x[i]][0] * sides.y[LOW, STRESS, i] / geometry.dy[0]
        force.x[i, ny - 1] += (
            geometry.aperture_x[geometry.pattern_x[i]][ny - 1] * sides.y[HIGH, STRESS, i] / geometry.dy[ny - 1]
        )


@kernel(exact=True)
def viscous_heating(velocity, a):
    """Power into cells, after `stress_force`: work on their halves of the faces, and heat. Over the box it is zero."""
    nx, ny = a.eta.shape
    rate, shear, normal, stretching, force = a.shear_rate, a.shear_stress, a.normal_stress, a.stretching, a.force
    for i in range(nx):
        k = i + 1
        for j in range(ny):
            m = j + 1
            in_x = velocity.x[i, j] * force.x[i, j] + velocity.x[k, j] * force.x[k, j]
            in_y = velocity.y[i, j] * force.y[i, j] + velocity.y[i, m] * force.y[i, m]
            stretched = normal[ALONG_X, i, j] * stretching[ALONG_X, i, j]
            stretched += normal[ALONG_Y, i, j] * stretching[ALONG_Y, i, j]
            near = shear[i, j] * rate[i, j] + shear[i, m] * rate[i, m]
            far = shear[k, j] * rate[k, j] + shear[k, m] * rate[k, m]
            a.heating[i, j] = stretched + 0.25 * (near + far)
            a.power[i, j] = 0.5 * (in_x + in_y) + a.heating[i, j]
