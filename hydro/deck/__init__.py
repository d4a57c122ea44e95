"""Decks: what a user asks for, read from TOML, checked, and complained about all at once."""

from hydro.deck.load import dumps, load, parse, validate
from hydro.deck.model import KINDS, BranchDeck, Deck, EvolutionDeck, StabilityDeck, SteadyDeck

__all__ = [
    "KINDS",
    "BranchDeck",
    "Deck",
    "EvolutionDeck",
    "StabilityDeck",
    "SteadyDeck",
    "dumps",
    "load",
    "parse",
    "validate",
]
