"""Vector fields on the faces of the cells."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydro.mesh.rectilinear import Mesh


class Faces(NamedTuple):
    """A vector field on the faces that it points through. Where a side is periodic, its two ends are the same face."""

    x: np.ndarray  # (nx+1, ny)
    y: np.ndarray  # (nx, ny+1)

    @classmethod
    def of(cls, mesh: Mesh) -> Faces:
        """Zero."""
        nx, ny = mesh.cells
        return cls(np.zeros((nx + 1, ny)), np.zeros((nx, ny + 1)))
