"""The kinds of deck. A new kind is a model and a line here, and what it does is a line in `hydro.kinds`."""

from __future__ import annotations

from hydro.deck.campaigns import PROBLEMS, ConvergenceDeck, SweepDeck
from hydro.deck.sections import Deck

KINDS: dict[str, type[Deck]] = {**PROBLEMS, "convergence": ConvergenceDeck, "sweep": SweepDeck}
