"""Differences between neighbouring cells as sparse matrices: what Newton's method and stability analysis share.

The finite volumes are those of `hydro.dynamics.godunov.heat`: five points, and what crosses a face is
said by `hydro.gas.conduction`. Cells are numbered as in a raveled (nx, ny) array.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from hydro.gas.conduction import conducted_heat, conducted_slope, face_conductance
from hydro.mesh import Mesh


class Faces:
    """The faces between cells, those in x first. No face lies in a wall.

    lower, upper: (faces,), numbers of the cells on both sides. weight: (faces,), length over distance between centres.
    """

    def __init__(self, mesh: Mesh):
        self.mesh = mesh
        nx, ny = mesh.cells
        cell = np.arange(nx * ny).reshape(nx, ny)
        self.lower = np.concatenate([cell[:-1].ravel(), cell[:, :-1].ravel()])
        self.upper = np.concatenate([cell[1:].ravel(), cell[:, 1:].ravel()])
        across_x = mesh.dy[None, :] / np.diff(mesh.x)[:, None]
        across_y = mesh.dx[:, None] / np.diff(mesh.y)[None, :]
        self.weight = np.concatenate([across_x.ravel(), across_y.ravel()])
        shape = (self.lower.size, cell.size)
        face = np.arange(self.lower.size)
        low, high = (sparse.csr_array((np.ones(face.size), (face, at)), shape) for at in (self.lower, self.upper))
        self._difference, self._sum = high - low, high + low
        self._divergence = -self._difference.T.tocsr()

    def diffused(self, coefficient: np.ndarray, field: np.ndarray) -> np.ndarray:
        """Integral over each cell of div(coefficient grad field); all (cells,)."""
        return self._divergence @ conducted_heat(self.weight, *self._sides(coefficient), *self._sides(field))

    def absolute(self, coefficient: np.ndarray, field: np.ndarray) -> np.ndarray:
        """As `diffused`, with every difference and sum taken without regard to sign: a bound of its errors."""
        low, high = self._sides(field)
        return abs(self._divergence) @ (face_conductance(self.weight, *self._sides(coefficient)) * (low + high))

    def diffusion(self, coefficient: np.ndarray) -> sparse.csr_array:
        """The matrix of `diffused` for a fixed coefficient, (cells, cells)."""
        return self._divergence @ scaled(face_conductance(self.weight, *self._sides(coefficient)), self._difference)

    def drift(self, field: np.ndarray) -> sparse.csr_array:
        """The matrix of `diffused` for a fixed field, as a function of the coefficient, (cells, cells)."""
        return self._divergence @ scaled(conducted_slope(self.weight, *self._sides(field)), self._sum)

    def _sides(self, field: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The values of a field below and above every face; (faces,)."""
        return field[self.lower], field[self.upper]


def scaled(factors: np.ndarray, matrix: sparse.csr_array) -> sparse.csr_array:
    """The matrix with its rows times `factors`."""
    return sparse.diags_array(factors) @ matrix


def diagonal(values: np.ndarray) -> sparse.dia_array:
    """A diagonal matrix."""
    return sparse.diags_array(values)
