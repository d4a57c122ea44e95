"""Decks: what a user asks for, read from TOML, checked, and complained about all at once."""

from hydro.deck.campaigns import ConvergenceDeck, SweepDeck
from hydro.deck.evolution import EvolutionDeck
from hydro.deck.grains import GrainsDeck
from hydro.deck.kinds import KINDS
from hydro.deck.load import changed, load, parse, validate
from hydro.deck.sections import Deck
from hydro.deck.stability import StabilityDeck
from hydro.deck.steady import BranchDeck, SteadyDeck
from hydro.deck.write import dumps

__all__ = [
    "KINDS",
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
