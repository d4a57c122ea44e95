"""The mesh as kernels see it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Geometry(NamedTuple):
    """The mesh as the heat kernels see it: widths, inverse distances between centres, periodic sides."""

    dx: np.ndarray  # (nx,)
    dy: np.ndarray  # (ny,)
    inverse_x: np.ndarray  # (nx+1,), face i lies between cells i-1 and i
    inverse_y: np.ndarray  # (ny+1,)
    periodic_x: bool
    periodic_y: bool

    @classmethod
    def of(cls, mesh) -> Geometry:
        return cls(mesh.dx, mesh.dy, inverse_distances(mesh.dx), inverse_distances(mesh.dy), *mesh.periodic)


def inverse_distances(widths: np.ndarray) -> np.ndarray:
    """One over the distance between neighbouring centres; at the ends, across a periodic side."""
    padded = np.concatenate([widths[-1:], widths, widths[:1]])
    return 2.0 / (padded[1:] + padded[:-1])
