"""The states that runs in time begin with: a file per kind, with the section that decks give it.

`state.py` says what every kind has in common, `exact.py` what those have whose evolution is exactly known.
"""

from __future__ import annotations

from typing import Any

from hydro.errors import Complaint, DeckError
from hydro.setup import gas_of, mesh_of
from hydro.state import State, inadmissible, worst_cell


def initial_state(deck: Any) -> State:
    """The state that the deck starts from; DeckError where n or T would leave its bounds."""
    state = deck.initial.state(deck, gas_of(deck), mesh_of(deck))
    if inadmissible(state).any():
        raise DeckError([Complaint("initial", worst_cell(state))], "initial state")
    return state
