"""A density that varies like a sum of cosines across the box."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field, ValidationInfo, field_validator

from hydro.initial.cosine import cosine_averages
from hydro.initial.state import Pattern, Patterned
from hydro.mesh import Mesh
from hydro.schema import Number, Wave, broken_rule, same_length


class ModesPattern(Pattern):
    """n is multiplied by 1 + the sum of amplitudes[i] cos(pi waves[i] y/aspect_ratio)."""

    kind: Literal["modes"] = "modes"
    waves: tuple[Wave, ...] = Field(min_length=1, description="numbers of half-waves across the box in y")
    amplitudes: tuple[Number, ...] = Field(
        description="relative amplitudes, one for each wave; their absolute values add to less than 1"
    )

    @field_validator("amplitudes")
    @classmethod
    def _check_amplitudes(cls, amplitudes: tuple[float, ...], info: ValidationInfo) -> tuple[float, ...]:
        same_length(amplitudes, "waves", info)
        if sum(map(abs, amplitudes)) >= 1:
            raise broken_rule("absolute values must add to less than 1")
        return amplitudes

    @property
    def largest(self) -> float:
        return sum(map(abs, self.amplitudes))

    def values(self, mesh: Mesh) -> np.ndarray:
        terms = (a * cosine_averages(mesh, wave) for a, wave in zip(self.amplitudes, self.waves, strict=True))
        return np.broadcast_to(sum(terms), mesh.cells)


class Modes(ModesPattern, Patterned):
    """At rest, n = f (1 + the sum of amplitudes[i] cos(pi waves[i] y/aspect_ratio))."""
