"""The made-up solution, to which every term of the equations contributes."""

from __future__ import annotations

from typing import Any, Literal

from hydro.initial.exact import CLOSED, GIVEN_HEAT, Evolution, ExactlyKnown
from hydro.setup import gas_of, viscosity_of, wall_of


class Manufactured(ExactlyKnown):
    """The made-up solution of hydro/exact/manufactured.py, kept by an added source; 0.35 < p < 0.65 and T about 1."""

    exact_if = (GIVEN_HEAT, CLOSED)
    needs_terms = True

    kind: Literal["manufactured"] = "manufactured"

    def evolution(self, deck: Any) -> Evolution:
        return solution(deck).conserved

    def terms(self, deck: Any) -> list[Any]:
        from hydro.terms import Source  # which waits for the compiler

        return [Source(solution(deck).source)]


def solution(deck: Any) -> Any:
    """The made-up solution in the deck's box."""
    from hydro.exact import Manufactured

    strength = getattr(wall_of(deck), "strength", 0.0)
    return Manufactured(gas_of(deck), deck.gas.tau, strength, deck.box.aspect_ratio, viscosity_of(deck))
