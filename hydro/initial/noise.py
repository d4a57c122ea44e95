"""A density with noise in every cell."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, Strict

from hydro.initial.state import Pattern, Patterned
from hydro.mesh import Mesh
from hydro.schema import NonNegative, Number
from hydro.state import State


class NoisePattern(Pattern):
    """n is multiplied by 1 + noise, uniform in +-amplitude, independent from cell to cell, its mean removed."""

    kind: Literal["noise"] = "noise"
    amplitude: Number = Field(default=0.01, ge=0, lt=1, description="half-width of the distribution")
    seed: Annotated[int, Strict()] = Field(default=0, ge=0, le=2**63 - 1, description="seed of the random numbers")

    @property
    def largest(self) -> float:
        return self.amplitude

    def values(self, mesh: Mesh) -> np.ndarray:
        field = np.random.default_rng(self.seed).uniform(-self.amplitude, self.amplitude, mesh.cells)
        return field - mesh.integral(field) / mesh.aspect_ratio


class Noise(NoisePattern, Patterned):
    """n = f (1 + noise), uniform in +-amplitude, independent from cell to cell, its mean removed; velocity likewise."""

    velocity: NonNegative = Field(
        default=0.0,
        description="root mean square of each component of the velocity, in T_*^(1/2): normally distributed, "
        "independent from cell to cell, without momentum of the whole gas; 0 for gas at rest",
    )

    def state(self, deck: Any, gas: Any, mesh: Mesh) -> State:
        density = deck.gas.f * (1.0 + self.values(mesh))
        return State.of(gas, mesh, density, self.temperature, self._velocities(density, mesh))

    def _velocities(self, density: np.ndarray, mesh: Mesh) -> np.ndarray:
        """Of every cell, (2, nx, ny). The random numbers are others than those of the density."""
        drawn = self.velocity * np.random.default_rng([self.seed, 1]).standard_normal((2, *mesh.cells))
        mass = density * mesh.areas
        return drawn - (mass * drawn).sum(axis=(1, 2), keepdims=True) / mass.sum()
