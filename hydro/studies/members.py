"""The runs that a study is made of: each an ordinary run in a folder of its own."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from hydro.choices import KINDS
from hydro.deck import Deck, changed
from hydro.deck.studies import Changes, ConvergenceDeck, SweepDeck
from hydro.output.folder import RunFolder


class Member(NamedTuple):
    """A run of a study: its number, from 1, its deck, and what of it is not as in the base deck."""

    number: int
    changes: Changes
    deck: Deck


def members_of(study: ConvergenceDeck | SweepDeck) -> list[Member]:
    """The runs of a study, in order; DeckError if a deck is not valid."""
    return [
        Member(number, changes, changed(study.base, changes)) for number, changes in enumerate(study.changes, start=1)
    ]


def completed(deck: Deck, folder: RunFolder) -> dict[str, Any] | None:
    """The summary of a deck's run, if the folder holds that run, completed."""
    summary = folder.read_summary() if folder.holds(deck) else {}
    return summary if summary.get("completed") else None


def run_member(deck: Deck, folder: RunFolder) -> dict[str, Any]:
    """The summary of a deck's run, as summary.json has it.

    A run that is completed in the folder is not repeated, one that was begun there goes on from its newest checkpoint.
    A HydroError comes through, after what was good has been saved.
    """
    kept, room = completed(deck, folder), KINDS[deck.kind]
    if kept is not None:
        return kept
    with folder.held():
        begun = folder.holds(deck) and folder.saved()
        run = room.resume if begun and room.resume is not None else room.solve
        run(deck, folder, True)
    return folder.read_summary()


def scalars_of(deck: Deck, summary: dict[str, Any]) -> dict[str, Any]:
    """The numbers that describe a completed run, by the names that decks of its kind know; None where there is none."""
    found = KINDS[deck.kind].scalars(summary)
    return {name: found.get(name) for name in deck.scalars}


def chained(deck: Deck, folder: str, perturbation: dict[str, Any] | None) -> Deck:
    """The evolution deck, to start from the last state of the run in a folder, at the deck's own mean density."""
    initial = {"kind": "checkpoint", "path": str(last_checkpoint(RunFolder(Path(folder)))), "refill": True}
    return changed(deck, {"initial": initial if perturbation is None else {**initial, "perturbation": perturbation}})


def last_checkpoint(folder: RunFolder) -> Path:
    """The checkpoint of the last state of an evolution."""
    return folder.saved()[-1]
