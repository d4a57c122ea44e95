"""Decks: what a user asks for, read from TOML, checked, and complained about all at once."""

from hydro.deck.load import dumps, load, parse, validate
from hydro.deck.model import KINDS, Deck, EvolutionDeck, StabilityDeck

__all__ = ["KINDS", "Deck", "EvolutionDeck", "StabilityDeck", "dumps", "load", "parse", "validate"]
