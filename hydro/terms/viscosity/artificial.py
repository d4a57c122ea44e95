"""A bulk viscosity that an integrator gives cell by cell, implicit in the velocities, where momentum is a face's."""

from __future__ import annotations

import numpy as np

from hydro.mesh import Faces, Geometry, Mesh
from hydro.terms.viscosity import implicit
from hydro.terms.viscosity.stress import Viscous, stress_force, viscous_heating
from hydro.walls.boundary import Boundary


class BulkViscosity:
    """Bulk viscosity `zeta` (nx, ny), zero in most cells; the faces of those are left alone, to the last bit.

    What it takes from the flow is heat: the sum of the energies of all cells stays, to round-off.
    """

    def __init__(self, boundary: Boundary, mesh: Mesh):
        self._sides, self._geometry = boundary.sides, Geometry.of(mesh)
        self._viscous, self._gradients, self._velocity = Viscous.of(mesh), implicit.Gradients.of(mesh), Faces.of(mesh)

    @property
    def zeta(self) -> np.ndarray:
        """The bulk viscosity of cells, in n_c T_*^(1/2) L_x."""
        return self._viscous.zeta

    @property
    def work(self) -> np.ndarray:
        """Two fields of cells, (2, nx, ny), for whoever sets `zeta`."""
        return self._viscous.stretching

    def resist(
        self, velocity: Faces, density: np.ndarray, pressure: np.ndarray, h: float, drag: float, momentum: Faces,
        energy: np.ndarray,
    ) -> np.ndarray:  # fmt: skip
        """Add its force and its heat over `h` to `momentum` of faces and `energy` of cells; returns the rate of heat.

        They are those of velocities that are implicit under `pressure`; `velocity` is where their search starts.
        """
        geometry, a, w, found = self._geometry, self._viscous, self._gradients, self._velocity
        found.x[:], found.y[:] = velocity
        implicit.load(geometry, self._sides, momentum, density, pressure, h, drag, a, w)
        implicit.relax(geometry, h, 0.0, found, a, w)
        stress_force(geometry, found, a)
        viscous_heating(found, a)
        momentum.x[:] += h * a.force.x
        momentum.y[:] += h * a.force.y
        energy += h * a.power
        return a.heating
