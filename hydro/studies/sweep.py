"""`kind = "sweep"`: runs of a base deck with some of its keys varied."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hydro.choices import KINDS
from hydro.deck import SweepDeck, dumps
from hydro.deck.studies import Variation
from hydro.errors import DeckError, RunFailed, Stopped
from hydro.kinds.kind import Kind
from hydro.output.folder import RunFolder
from hydro.progress import expected
from hydro.studies.cluster import Outcome, Start, client_of, outcomes, work
from hydro.studies.members import Member, chained, completed, members_of, scalars_of
from hydro.studies.table import write_table

if TYPE_CHECKING:
    from xarray import Dataset

NOT_RUN = Outcome(completed=False, summary=None, error="not run")


def solve(deck: SweepDeck, folder: RunFolder, quiet: bool = False, scheduler: str | None = None) -> dict[str, Any]:
    """Run every member, in processes of this machine or on the Dask cluster of `scheduler`; returns the summary.

    Members that were completed in this folder before, by the same deck, are kept. RunFailed if members failed, Stopped
    if a signal came; in both cases what is finished is in the summary.
    """
    started, members = time.perf_counter(), members_of(deck)
    found = {} if folder.anew or not folder.holds(deck) else kept(deck, members, folder)
    left = [member for member in members if member.number not in found]
    with client_of(scheduler, len(left)) if left else contextlib.nullcontext() as client:
        folder.resume(deck)
        try:
            results = run(client, deck, left, found, folder) if left else ()
            for number, outcome in expected(results, len(left), folder.path.name, quiet):
                found[number] = outcome
        except KeyboardInterrupt:
            finish(deck, folder, members, found, started)
            raise Stopped(f"stopped; {len(found)} of {len(members)} members are kept: again, to go on") from None
    summary = finish(deck, folder, members, found, started)
    if failed := [number for number in sorted(found) if not found[number]["completed"]]:
        lines = [f"member {number}: {found[number]['error']}" for number in failed]
        raise RunFailed("\n  ".join([f"{len(failed)} of {len(members)} members failed, the others are kept", *lines]))
    return summary


def start_of(deck: SweepDeck, member: Member, folder: RunFolder) -> Start | None:
    """How a member of a chain starts from the one before; None for the first of a chain, and where there is none."""
    if not deck.sweep.chain or (member.number - 1) % len(deck.sweep.axes[-1].changes) == 0:
        return None
    pattern = deck.sweep.perturbation
    before = folder.member(member.number - 1).path.resolve()
    return Start(folder=str(before), perturbation=pattern.model_dump() if pattern else None)


def kept(deck: SweepDeck, members: list[Member], folder: RunFolder) -> dict[int, Outcome]:
    """What was completed in this folder before."""
    found: dict[int, Outcome] = {}
    for member in members:
        start = start_of(deck, member, folder)
        if start is not None and member.number - 1 not in found:
            continue
        whole = member.deck if start is None else chained(member.deck, **start)
        summary = completed(whole, folder.member(member.number))
        if summary is not None:
            found[member.number] = Outcome(completed=True, summary=summary, error=None)
    return found


def run(
    client: Any, deck: SweepDeck, members: list[Member], known: dict[int, Outcome], folder: RunFolder
) -> Iterator[tuple[int, Outcome]]:
    """Hand members to the workers; numbers and outcomes as they finish. Those of a chain wait for the one before."""
    futures: dict[int, Any] = {}
    for member in members:
        start, path = start_of(deck, member, folder), str(folder.member(member.number).path.resolve())
        before = None if start is None else futures.get(member.number - 1) or known[member.number - 1]
        futures[member.number] = client.submit(work, dumps(member.deck), path, start, before, pure=False)
    yield from outcomes(client, {future: number for number, future in futures.items()})


def finish(
    deck: SweepDeck, folder: RunFolder, members: list[Member], found: dict[int, Outcome], started: float
) -> dict[str, Any]:
    """Write summary, table and pictures."""
    entries: list[dict[str, Any]] = [
        {
            "overrides": member.changes,
            "folder": str(folder.member(member.number).path.relative_to(folder.path)),
            **found.get(member.number, NOT_RUN),
        }
        for member in members
    ]
    summary = {
        "kind": deck.kind,
        "completed": all(entry["completed"] for entry in entries),
        "wall_seconds": time.perf_counter() - started,
        "members": entries,
        "missed": [
            f"member {number}: {line}"
            for number, entry in enumerate(entries, start=1)
            for line in (entry["summary"] or {}).get("missed", ())
        ],
    }
    folder.write_summary(summary)
    write_table(folder.table, rows_of(members, entries))
    if any(entry["completed"] for entry in entries):
        from hydro.pictures.sweep import draw  # matplotlib is slow to import

        for name in deck.sweep.draw or deck.base.scalars[:1]:
            draw(folder.pictures / name, open_sweep(folder.path), name, deck.sweep.chain)
    return summary


def rows_of(members: list[Member], entries: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """One row for each member: its values, whether it is completed, its scalars, its folder."""
    rows = []
    for member, entry in zip(members, entries, strict=True):
        scalars: dict[str, Any] = dict.fromkeys(member.deck.scalars)
        if entry["completed"]:
            scalars = scalars_of(member.deck, entry["summary"])
        rows.append({**member.changes, "completed": entry["completed"], **scalars, "folder": entry["folder"]})
    return rows


def open_sweep(path: str | Path) -> Dataset:
    """The table of the sweep in a folder as an xarray Dataset.

    A dimension for each axis of the deck, named by its first key, with its values as coordinates; its other keys are
    coordinates along it. Variables: `member`, `completed`, and the scalars of the runs, NaN where there is none.
    DeckError if the folder holds no sweep.
    """
    import numpy as np
    import xarray

    folder = RunFolder(Path(path))
    deck = folder.load_deck()
    if not isinstance(deck, SweepDeck):
        raise DeckError(f"{path} holds a run of kind {deck.kind!r}, not a sweep", "run folder")
    members = members_of(deck)
    rows = rows_of(members, folder.read_summary()["members"])
    dims = [axis.keys[0] for axis in deck.sweep.axes]
    shape = [len(axis.changes) for axis in deck.sweep.axes]
    coordinates = {key: (axis.keys[0], column(axis, key)) for axis in deck.sweep.axes for key in axis.keys}
    numbers = {
        name: (dims, np.array([np.nan if row[name] is None else row[name] for row in rows], float).reshape(shape))
        for name in deck.base.scalars
    }
    flags = {
        "member": (dims, np.arange(1, len(rows) + 1).reshape(shape)),
        "completed": (dims, np.array([row["completed"] for row in rows]).reshape(shape)),
    }
    return xarray.Dataset({**flags, **numbers}, coordinates)


def column(axis: Variation, key: str) -> list[Any]:
    """The values of a key along its axis: numbers, or else text."""
    values = [changes[key] for changes in axis.changes]
    numbers = all(isinstance(value, int | float) for value in values)
    return [float(value) for value in values] if numbers else [text(value) for value in values]


def text(value: Any) -> str:
    """A value of a key, a section too, in a few words."""
    return ", ".join(f"{key} {item}" for key, item in value.items()) if isinstance(value, dict) else str(value)


def describe(deck: SweepDeck) -> list[str]:
    """Lines on what will be run, for `check`: the axes, and the scales of the first member."""
    members = members_of(deck)
    axes = [f"{', '.join(axis.keys)}: {len(axis.changes)} values" for axis in deck.sweep.axes]
    first = members[0].deck
    return [*axes, f"{len(members)} members; the first of them:", *KINDS[first.kind].describe(first)]


def closing(summary: dict[str, Any]) -> list[str]:
    """How many members are there."""
    done = sum(entry["completed"] for entry in summary["members"])
    return [f"{done} of {len(summary['members'])} members in {summary['wall_seconds']:.1f} s"]


KIND = Kind(solve, describe, closing, resume=solve)
