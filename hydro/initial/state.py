"""What every initial state, and every pattern that changes a density, has in common."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple

import numpy as np
from pydantic import Field

from hydro.mesh import Mesh
from hydro.schema import Positive, Tagged
from hydro.state import State


class Condition(NamedTuple):
    """What an exact evolution needs of its deck."""

    key: str
    holds: Callable[[Any], bool]
    words: str


class InitialState(Tagged):
    """The state at t=0. A new kind derives from this, has its keys as fields, and gives `state`."""

    # What a deck must fulfil for its evolution to be known exactly; None where it never is.
    exact_if: ClassVar[tuple[Condition, ...] | None] = None
    needs_terms: ClassVar[bool] = False  # whether it evolves as it should only with `terms`

    def state(self, deck: Any, gas: Any, mesh: Mesh) -> State:
        """The state of a deck, of this gas on this mesh."""
        raise NotImplementedError

    def terms(self, deck: Any) -> list[Any]:
        """Terms of the equations (`hydro.terms.Term`) beside those that the deck names."""
        return []

    @property
    def needs_area_fraction(self) -> bool:
        """Whether the state has the mean density gas.f."""
        return False

    @property
    def largest(self) -> float:
        """Upper bound of the relative excess of the density over the area fraction, where that is known."""
        return 0.0


class MeanDensity(InitialState):
    """A state of given mean density gas.f and uniform temperature."""

    temperature: Positive = Field(default=1.0, description="temperature of the gas, in T_*")

    @property
    def needs_area_fraction(self) -> bool:
        return True


class Pattern(Tagged):
    """Relative change of a density, to be multiplied onto it."""

    @property
    def largest(self) -> float:
        """Upper bound of the relative change."""
        raise NotImplementedError

    def values(self, mesh: Mesh) -> np.ndarray:
        """The relative change in every cell, shape (nx, ny)."""
        raise NotImplementedError


class Patterned(MeanDensity):
    """At rest, n = f times one plus a pattern, from which a kind derives, too."""

    def state(self, deck: Any, gas: Any, mesh: Mesh) -> State:
        return State.of(gas, mesh, deck.gas.f * (1.0 + self.values(mesh)), self.temperature)  # type: ignore[attr-defined]
