"""Viscosity of the gas: shear and bulk, a multiple of what the closure gives."""

from __future__ import annotations

from typing import Any, Self

import numpy as np

from hydro.errors import StepRejected
from hydro.gas import Closure
from hydro.mesh import Faces, Geometry, Mesh
from hydro.terms.term import Term
from hydro.terms.viscosity import explicit, implicit
from hydro.terms.viscosity.stress import Viscous, stress_force, viscous_heating
from hydro.walls.boundary import Boundary


class Viscosity(Term):
    """factor: over the viscosities of the closure. No energy comes or goes: what the flow loses is heat."""

    def __init__(self, factor: float = 1.0):
        self.factor = factor

    @classmethod
    def of(cls, deck: Any) -> Self:
        """That of the deck."""
        return cls(deck.gas.viscosity)

    def stress(self, gas: Closure, boundary: Boundary, mesh: Mesh) -> ViscousStress | None:
        return ViscousStress(gas, self.factor, boundary, mesh) if self.factor > 0.0 and gas.conducts() else None


class ViscousStress:
    """Viscous stress of a gas on a mesh; 216 bytes of work space per cell."""

    def __init__(self, gas: Closure, factor: float, boundary: Boundary, mesh: Mesh):
        self.gas, self.factor, self.sides, self.mesh = gas, factor, boundary.sides, mesh
        self.geometry, self._viscous, self._velocity = Geometry.of(mesh), Viscous.of(mesh), Faces.of(mesh)
        self._stages: explicit.Stages | None = None
        self._gradients: implicit.Gradients | None = None
        self.iterations = 0  # of all implicit steps so far

    def advance(self, state: np.ndarray, dt: float, spared: np.ndarray) -> None:
        """Viscous flow of the conserved `state` (4, nx, ny) for `dt`, at frozen density; see `Stress`."""
        self._stages = self._stages or explicit.Stages.of(self.mesh)
        explicit.advance(
            self.gas, self.factor, self.geometry, self.sides, self._viscous, self._velocity, self._stages, state, dt,
            spared,
        )  # fmt: skip

    def implicit(
        self, velocity: Faces, density: np.ndarray, pressure: np.ndarray, pushing: np.ndarray, h: float, drag: float,
        momentum: Faces, energy: np.ndarray,
    ) -> np.ndarray:  # fmt: skip
        """Viscosity over `h`, implicit in the velocities, into `momentum` and `energy`; see `Stress`. StepRejected."""
        self._gradients = self._gradients or implicit.Gradients.of(self.mesh)
        geometry, a, w, found = self.geometry, self._viscous, self._gradients, self._velocity
        found.x[:], found.y[:] = velocity
        total = implicit.prepare(self.gas, self.factor, geometry, density, pressure, pushing, a)
        implicit.load(geometry, self.sides, momentum, density, pushing, h, drag, a, w)
        iterations = implicit.relax(geometry, h, implicit.NOISE**2 * total, found, a, w)
        stress_force(geometry, found, a)
        viscous_heating(found, a)
        implicit.hand_over(geometry, pushing, h, found, a, w, momentum, energy)
        self.iterations += iterations
        if iterations == implicit.ITERATIONS:
            raise StepRejected(f"the viscous velocities do not converge in {iterations} iterations")
        return a.heating
