"""Differences between neighbouring cells as sparse matrices: what Newton's method and stability analysis share.

The finite volumes are those of the heat operator of `hydro.dynamics.heat`: five points, and the coefficient of a
face is the mean of its two cells'. Cells are numbered as in a raveled (nx, ny) array.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from hydro.mesh import Mesh


class Faces:
    """The faces between cells, those in x first. No face lies in a wall.

    difference: (faces, cells), upper cell less lower cell. mean: (faces, cells).
    weight: (faces,), length over distance between centres.
    """

    def __init__(self, mesh: Mesh):
        self.mesh = mesh
        nx, ny = mesh.cells
        cell = np.arange(nx * ny).reshape(nx, ny)
        lower = np.concatenate([cell[:-1].ravel(), cell[:, :-1].ravel()])
        upper = np.concatenate([cell[1:].ravel(), cell[:, 1:].ravel()])
        across_x = mesh.dy[None, :] / np.diff(mesh.x)[:, None]
        across_y = mesh.dx[:, None] / np.diff(mesh.y)[None, :]
        self.weight = np.concatenate([across_x.ravel(), across_y.ravel()])
        shape = (lower.size, cell.size)
        face = np.arange(lower.size)
        low, high = (sparse.csr_array((np.ones(face.size), (face, at)), shape) for at in (lower, upper))
        self.difference, self.mean = high - low, 0.5 * (high + low)
        self._divergence = -self.difference.T.tocsr()

    def diffused(self, coefficient: np.ndarray, field: np.ndarray) -> np.ndarray:
        """Integral over each cell of div(coefficient grad field); all (cells,)."""
        return self._divergence @ (self.weight * (self.mean @ coefficient) * (self.difference @ field))

    def absolute(self, coefficient: np.ndarray, field: np.ndarray) -> np.ndarray:
        """As `diffused`, with every difference and sum taken without regard to sign: a bound of its errors."""
        return abs(self._divergence) @ (self.weight * (self.mean @ coefficient) * (abs(self.difference) @ field))

    def diffusion(self, coefficient: np.ndarray) -> sparse.csr_array:
        """The matrix of `diffused` for a fixed coefficient, (cells, cells)."""
        return self._divergence @ scaled(self.weight * (self.mean @ coefficient), self.difference)

    def drift(self, field: np.ndarray) -> sparse.csr_array:
        """The matrix of `diffused` for a fixed field, as a function of the coefficient, (cells, cells)."""
        return self._divergence @ scaled(self.weight * (self.difference @ field), self.mean)


def scaled(factors: np.ndarray, matrix: sparse.csr_array) -> sparse.csr_array:
    """The matrix with its rows times `factors`."""
    return sparse.diags_array(factors) @ matrix


def diagonal(values: np.ndarray) -> sparse.dia_array:
    """A diagonal matrix."""
    return sparse.diags_array(values)
