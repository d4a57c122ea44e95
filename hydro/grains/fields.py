"""Fields of grains: what lies in each cell of a mesh."""

from __future__ import annotations

import numpy as np

from hydro.grains.dynamics import Dynamics
from hydro.grains.placement import CLOSE_PACKING, cells_of
from hydro.mesh import Mesh


def fields(grains: Dynamics, mesh: Mesh) -> np.ndarray:
    """Density, momenta and energy of grains by cell, scaled as those of a `State`, shape (4, nx, ny).

    A grain counts for the cell that holds its centre: the sums over the mesh are those over the grains.
    """
    velocities = grains.velocities
    i, j = cells_of(grains.places, mesh.x_faces, mesh.y_faces)
    carried = (None, velocities[:, 0], velocities[:, 1], 0.5 * (velocities**2).sum(axis=1))
    cell, size = i * mesh.dy.size + j, mesh.areas.size
    sums = np.array([np.bincount(cell, weights, size) for weights in carried]).reshape(4, *mesh.cells)
    return sums / (mesh.areas * density_scale(grains.arena.diameter))


def density_scale(diameter: float) -> float:
    """n_c in units of 1/L_x^2."""
    return CLOSE_PACKING / diameter**2
