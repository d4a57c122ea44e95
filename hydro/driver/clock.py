"""Clocks that count something else than time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from hydro.accounts import Account
from hydro.check.regime import Grains
from hydro.observables.cooling import cools_freely
from hydro.state import State

COLLISIONS_PER_GRAIN = Account("collisions_per_grain", 0, "collisions that a grain has had on average", "1")


class Clock(NamedTuple):
    """Counts the integral of `rate(state)` over time, by the trapezoidal rule from step to step."""

    account: Account
    rate: Callable[[State], float]


def collision_clock(deck: Any) -> Clock | None:
    """Counts the collisions of a grain in a gas that cools freely; None for decks of other problems.

    A collision of two grains costs (1-r^2) T on average, so a grain has 2 I/((1-r^2) n T) in unit time.
    """
    if not cools_freely(deck):
        return None
    loss = Grains.of(deck).inelasticity(deck.gas.L)

    def rate(state: State) -> float:
        lost = state.gas.cooling(state.density, state.temperature) / state.temperature
        return 2.0 * state.mesh.integral(lost) / (loss * state.mass)

    return Clock(COLLISIONS_PER_GRAIN, rate)
