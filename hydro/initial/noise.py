"""A density with noise in every cell."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, Strict

from hydro.initial.state import Pattern, Patterned
from hydro.mesh import Mesh
from hydro.schema import Number


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
    """At rest, n = f (1 + noise), uniform in +-amplitude, independent from cell to cell, its mean removed."""
