"""The mesh, and its geometry as kernels see it."""

from hydro.mesh.faces import Faces
from hydro.mesh.geometry import Geometry, inverse_distances
from hydro.mesh.rectilinear import GHOSTS, Mesh

__all__ = ["GHOSTS", "Faces", "Geometry", "Mesh", "inverse_distances"]
