"""Runs of evolution decks inside a process, without files."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from hydro.deck import EvolutionDeck, load
from hydro.driver.march import Run, march
from hydro.driver.trackers import AtTimes
from hydro.initial import initial_state
from hydro.setup import integrator_of


def evolve(path: Path, overrides: Iterable[str], watch: Callable[[Run], None], every: float | None = None) -> Run:
    """The run of a deck to its end; `watch` sees it at the deck's output times and at multiples of `every`."""
    deck = load(path, overrides)
    assert isinstance(deck, EvolutionDeck)
    state = initial_state(deck)
    return march(state, integrator_of(deck, state), deck.time.end, [AtTimes(watch, deck.output_times, every)])
