"""The runs that a study is made of: each an ordinary run in a folder of its own."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from hydro.deck import Deck, changed, dumps
from hydro.deck.campaigns import Changes, ConvergenceDeck, SweepDeck
from hydro.runs.folder import RunFolder


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
    if not (folder.holds(dumps(deck)) and folder.summary.exists()):
        return None
    summary = folder.read_summary()
    return summary if summary["completed"] else None


def run_member(deck: Deck, folder: RunFolder) -> dict[str, Any]:
    """The summary of a deck's run, as summary.json has it; one that is completed in the folder is not repeated.

    A HydroError comes through, after what was good has been saved.
    """
    from hydro.kinds import KINDS  # which has the kinds of studies too

    kept = completed(deck, folder)
    if kept is not None:
        return kept
    KINDS[deck.kind].solve(deck, folder, True)
    return folder.read_summary()


def scalars_of(deck: Deck, summary: dict[str, Any]) -> dict[str, Any]:
    """The numbers that describe a completed run, by the names that decks of its kind know; None where there is none."""
    from hydro.kinds import KINDS

    found = KINDS[deck.kind].scalars(summary)
    return {name: found.get(name) for name in deck.scalars}


def chained(deck: Deck, folder: str, perturbation: dict[str, Any] | None) -> Deck:
    """The evolution deck, to start from the last state of the run in a folder, at the deck's own mean density."""
    initial = {"kind": "checkpoint", "path": str(last_checkpoint(RunFolder(Path(folder)))), "refill": True}
    return changed(deck, {"initial": initial if perturbation is None else {**initial, "perturbation": perturbation}})


def last_checkpoint(folder: RunFolder) -> Path:
    """The checkpoint of the last state of an evolution."""
    return sorted(folder.checkpoints.glob("*.h5"))[-1]
