"""Rolling friction, - n v/tau: it takes energy of the flow, and gives no heat to the gas."""

from __future__ import annotations

from typing import Any, Self

from hydro.accounts import FRICTION
from hydro.terms.term import Term


class Friction(Term):
    """Slows the flow down within the time tau, scaled; infinite for none."""

    account = FRICTION

    def __init__(self, tau: float):
        self.tau = tau

    @classmethod
    def of(cls, deck: Any) -> Self:
        """That of the deck."""
        return cls(deck.gas.tau)

    def drag_rate(self) -> float:
        return 1.0 / self.tau
