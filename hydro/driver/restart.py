"""Going on with a run that was stopped, killed, or is to go further than it did."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from hydro.deck import Deck, load, parse
from hydro.errors import CheckpointError, Complaint, DeckError
from hydro.output.checkpoint import Checkpoint, read_or_skip
from hydro.output.folder import DAMAGED, RunFolder

CHANGEABLE = ("about", "output", "movie", "time", "grains.contact_time")  # sections, and keys of others
FIXED = ("time.integrator",)


def deck_of(folder: RunFolder, overrides: Iterable[str]) -> Deck:
    """The deck of the run in a folder, changed by overrides; that of its newest checkpoint if the file is lost.

    DeckError if the folder holds no run, or the deck or an override is not valid.
    """
    if folder.deck.exists():
        return load(folder.deck, overrides)
    saved = newest_checkpoint(folder)
    if saved is None:
        raise DeckError(f"{folder.path} holds no run", "restart")
    print(f"hydro: {folder.deck} is missing: the deck in the checkpoint is taken", file=sys.stderr)
    return parse(saved.deck, overrides, "checkpoint")


def newest_checkpoint(folder: RunFolder) -> Checkpoint | None:
    """The newest checkpoint that can be read; None where there are none.

    Newer ones that cannot be read are named on stderr and renamed. CheckpointError if there are only such.
    """
    paths = folder.saved()
    for age, path in enumerate(reversed(paths)):
        if (saved := read_or_skip(path)) is not None:
            for bad in paths[len(paths) - age :]:
                bad.rename(bad.with_name(bad.name + DAMAGED))
            return saved
    if paths:
        raise CheckpointError(f"{folder.path}: none of its checkpoints can be read; --overwrite would begin anew")
    return None


def refuse_changes(deck: Deck, saved: Checkpoint) -> None:
    """DeckError where `deck` asks for another problem than that of the checkpoint."""
    now, then = (dict(_flat(each.model_dump())) for each in (deck, parse(saved.deck, source="checkpoint")))
    complaints = [
        Complaint(key, f"{now.get(key)} is not what the run was started with, {then.get(key)}", now.get(key))
        for key in dict.fromkeys([*then, *now])
        if now.get(key) != then.get(key) and (key in FIXED or not {key, key.partition(".")[0]} & {*CHANGEABLE})
    ]
    if complaints:
        allowed = f"a restart may change {', '.join(CHANGEABLE)}, but not {', '.join(FIXED)}"
        raise DeckError(complaints, f"{allowed}; another run may start from a checkpoint by initial.kind=checkpoint")


def _flat(table: Mapping[str, Any], name: str = "") -> Iterator[tuple[str, Any]]:
    """Values with their dotted keys."""
    for key, value in table.items():
        dotted = f"{name}.{key}".removeprefix(".")
        if isinstance(value, Mapping):
            yield from _flat(value, dotted)
        else:
            yield dotted, value
