"""A uniform gas, which cools."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from pydantic import Field

from hydro.initial.exact import AT_REST, UNHEATED, Evolution, ExactlyKnown
from hydro.initial.state import MeanDensity
from hydro.mesh import Mesh
from hydro.schema import Vector
from hydro.setup import gas_of
from hydro.state import State


class Uniform(ExactlyKnown, MeanDensity):
    """Uniform density f, temperature and velocity."""

    exact_if = (UNHEATED, AT_REST)

    kind: Literal["uniform"] = "uniform"
    velocity: Vector = Field(default=(0.0, 0.0), description="velocity [u, v], in T_*^(1/2)")

    def evolution(self, deck: Any) -> Evolution:
        """Homogeneous cooling of a gas that moves as a whole, if at all, and is slowed down by friction."""
        from hydro.exact import homogeneous_cooling

        gas, n = gas_of(deck), deck.gas.f

        def conserved(mesh: Mesh, t: float) -> np.ndarray:
            T, keep = homogeneous_cooling(gas, n, self.temperature, t), np.exp(-t / deck.gas.tau)
            return State.of(gas, mesh, n, T, (keep * self.velocity[0], keep * self.velocity[1])).conserved

        return conserved
