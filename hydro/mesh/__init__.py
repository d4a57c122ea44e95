"""The mesh, and its geometry as kernels see it."""

from hydro.mesh.geometry import Geometry, inverse_distances
from hydro.mesh.rectilinear import GHOSTS, Mesh

__all__ = ["GHOSTS", "Geometry", "Mesh", "inverse_distances"]
