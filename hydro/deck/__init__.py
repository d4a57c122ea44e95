"""Decks: what a user asks for, read from TOML, checked, and complained about all at once.

    reading      files, base decks and overrides to a valid deck
    overrides    values put into a deck before it is checked
    validation   what the sections demand, and what follows from other parts of the deck
    complaints   what is wrong, in words
    writing      a deck as TOML

The other files are the models of decks: what several kinds share, and a file per kind.
"""

from hydro.deck.evolution import EvolutionDeck
from hydro.deck.grains import GrainsDeck
from hydro.deck.reading import load, parse
from hydro.deck.sections import Deck
from hydro.deck.stability import StabilityDeck
from hydro.deck.steady import BranchDeck, SteadyDeck
from hydro.deck.studies import ConvergenceDeck, SweepDeck
from hydro.deck.validation import changed, validate
from hydro.deck.writing import dumps

__all__ = [
    "BranchDeck",
    "ConvergenceDeck",
    "Deck",
    "EvolutionDeck",
    "GrainsDeck",
    "StabilityDeck",
    "SteadyDeck",
    "SweepDeck",
    "changed",
    "dumps",
    "load",
    "parse",
    "validate",
]
