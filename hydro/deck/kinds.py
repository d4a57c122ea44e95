"""The kinds of deck. A new kind is a model and a line here, and what it does is a line in `hydro.kinds`."""

from __future__ import annotations

from hydro.deck.evolution import EvolutionDeck
from hydro.deck.grains import GrainsDeck
from hydro.deck.sections import Deck
from hydro.deck.stability import StabilityDeck
from hydro.deck.steady import BranchDeck, SteadyDeck

KINDS: dict[str, type[Deck]] = {
    "evolution": EvolutionDeck,
    "steady": SteadyDeck,
    "branch": BranchDeck,
    "stability": StabilityDeck,
    "grains": GrainsDeck,
}
