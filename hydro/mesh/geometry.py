"""The mesh as kernels see it: lengths of faces, distances between centres, areas of cells."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

OPEN, CLOSED = 0, 1  # rows of the tables of apertures


class Geometry(NamedTuple):
    """Widths, distances, scale factors and apertures of a mesh of (nx, ny) cells.

    A unit of y is `scale` long, which may change with x (one here; the radius in an annulus). An aperture is the open
    share of a face: one, or zero where a face is closed, as those on walls are. Rows of apertures that are alike are
    kept once: `aperture_x[pattern_x[i]]` is the row of the faces in x below the cells of row i.

        face in x:  length scale_x[i] dy[j] aperture,    distance of centres 1/inverse_x[i]
        face in y:  length dx[i] aperture,               distance of centres scale[i]/inverse_y[j]
        cell:       area scale[i] dx[i] dy[j]
    """

    dx: np.ndarray  # (nx,)
    dy: np.ndarray  # (ny,)
    over_dy: np.ndarray  # (ny,), one over it
    inverse_x: np.ndarray  # (nx+1,), face i lies between cells i-1 and i
    inverse_y: np.ndarray  # (ny+1,)
    scale: np.ndarray  # (nx,), in the middle of a row of cells
    scale_x: np.ndarray  # (nx+1,), on the faces in x
    aperture_x: np.ndarray  # (patterns, ny)
    pattern_x: np.ndarray  # (nx+1,)
    aperture_y: np.ndarray  # (patterns, ny+1)
    pattern_y: np.ndarray  # (nx,)
    weight_y: np.ndarray  # (patterns, ny+1), aperture over distance: aperture_y * inverse_y
    spacing_x: np.ndarray  # (3, nx + 2 GHOSTS), see `Mesh.spacing`
    spacing_y: np.ndarray  # (3, ny + 2 GHOSTS)
    periodic_x: bool
    periodic_y: bool

    @classmethod
    def of(cls, mesh) -> Geometry:
        """Of a rectilinear mesh, whose sides are walls where they are not periodic."""
        nx, ny = mesh.cells
        periodic_x, periodic_y = mesh.periodic
        aperture_x = np.array([np.ones(ny), np.zeros(ny)])
        pattern_x = np.full(nx + 1, OPEN)
        pattern_x[[0, nx]] = OPEN if periodic_x else CLOSED
        aperture_y = np.ones((1, ny + 1))
        aperture_y[0, [0, ny]] = 1.0 if periodic_y else 0.0
        inverse_x, inverse_y = inverse_distances(mesh.dx), inverse_distances(mesh.dy)
        return cls(
            mesh.dx, mesh.dy, 1.0 / mesh.dy, inverse_x, inverse_y, np.ones(nx), np.ones(nx + 1), aperture_x,
            pattern_x, aperture_y, np.zeros(nx, int), aperture_y * inverse_y, mesh.spacing(0), mesh.spacing(1),
            periodic_x, periodic_y,
        )  # fmt: skip


def inverse_distances(widths: np.ndarray) -> np.ndarray:
    """One over the distance between neighbouring centres; at the ends, across a periodic side."""
    padded = np.concatenate([widths[-1:], widths, widths[:1]])
    return 2.0 / (padded[1:] + padded[:-1])
