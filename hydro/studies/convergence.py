"""`kind = "convergence"`: errors on a ladder of grids and steps, their orders, and limits of scalars."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from itertools import groupby
from typing import Any

from hydro.choices import KINDS
from hydro.deck import ConvergenceDeck, Deck
from hydro.deck.studies import Changes
from hydro.errors import HydroError
from hydro.kinds.kind import Kind
from hydro.output.checkpoint import Checkpoint, read_checkpoint
from hydro.output.folder import RunFolder
from hydro.progress import counted
from hydro.studies.members import Member, last_checkpoint, members_of, run_member, scalars_of
from hydro.studies.orders import orders, richardson
from hydro.studies.references import NAMES, TOTAL, Level, check_nested, errors
from hydro.studies.table import write_table

# Where runs leave the state that they end in.
ENDS: dict[str, Callable[[RunFolder], Any]] = {
    "evolution": last_checkpoint,
    "steady": lambda folder: folder.checkpoints / "steady.h5",
}


def solve(deck: ConvergenceDeck, folder: RunFolder, quiet: bool = False) -> dict[str, Any]:
    """Run every level and measure it; returns the summary, in which `missed` says what the deck expected in vain.

    Levels that were completed in this folder before, by the same deck, are kept. A HydroError in a level comes through
    after the summary of the ladders that are finished has been written.
    """
    started, members = time.perf_counter(), members_of(deck)
    for ladder in ladders(deck, members):
        check_nested([member.deck for member in ladder], deck.convergence.reference)
    folder.resume(deck)
    finished: list[Member] = []
    try:
        for member in counted(members, folder.path.name, quiet):
            run_member(member.deck, folder.member(member.number))
            finished.append(member)
    except HydroError as error:
        finish(deck, folder, finished, started)
        raise type(error)(f"{error}\n{len(finished)} of {len(members)} runs are finished; again, to go on") from error
    return finish(deck, folder, finished, started)


def finish(deck: ConvergenceDeck, folder: RunFolder, finished: list[Member], started: float) -> dict[str, Any]:
    """Measure the ladders that are complete; write summary, table and picture."""
    rows: list[dict[str, Any]] = []
    limits: list[dict[str, Any]] = []
    complete = [ladder for ladder in ladders(deck, finished) if len(ladder) == len(deck.convergence.ladder.changes)]
    for ladder in complete:
        measured = measure(deck, folder, ladder)
        rows += measured
        limits += limits_of(deck, measured)
    summary = {
        "kind": deck.kind,
        "completed": len(finished) == len(deck.changes),
        "reference": deck.convergence.reference,
        "wall_seconds": time.perf_counter() - started,
        "rows": rows,
        "limits": limits,
        "missed": list(missed(deck, rows, limits)),
    }
    folder.write_summary(summary)
    if rows:
        write_table(folder.table, [flat(row) for row in rows])
        from hydro.pictures.convergence import draw  # matplotlib is slow to import

        draw(folder.pictures / "convergence", summary, deck.convergence.order)
    return summary


def ladders(deck: ConvergenceDeck, members: list[Member]) -> list[list[Member]]:
    """The runs of each variant, coarse to fine."""
    levels = len(deck.convergence.ladder.changes)
    return [list(group) for _, group in groupby(members, key=lambda member: (member.number - 1) // levels)]


def measure(deck: ConvergenceDeck, folder: RunFolder, ladder: list[Member]) -> list[dict[str, Any]]:
    """One row for each level: what it is, its errors, their orders from the level before, and its scalars."""
    folders = [folder.member(member.number) for member in ladder]
    levels = [Level(member.deck, end_of(member.deck, place)) for member, place in zip(ladder, folders, strict=True)]
    sizes = deck.convergence.sizes
    found = errors(levels, deck.convergence.reference)
    rows: list[dict[str, Any]] = []
    for member, place, level, size, error in zip(ladder, folders, levels, sizes, found, strict=True):
        numbers = scalars_of(member.deck, place.read_summary())
        rows.append({
            "variant": variant_of(deck, member.changes),
            "changes": member.changes,
            "cells": list(level.end.mesh.cells),
            "dt": level.end.time / level.end.steps if level.end.steps else None,
            "size": size / sizes[0],
            "errors": error,
            "orders": observed(rows[-1], size / sizes[0], error) if rows else dict.fromkeys((*NAMES, TOTAL)),
            "scalars": {name: numbers[name] for name in deck.convergence.scalars},
            "folder": str(place.path.relative_to(folder.path)),
        })  # fmt: skip
    return rows


def end_of(deck: Deck, folder: RunFolder) -> Checkpoint:
    """The state that a run has ended in."""
    return read_checkpoint(ENDS[deck.kind](folder))


def variant_of(deck: ConvergenceDeck, changes: Changes) -> Changes:
    """What a run has not in common with its like in other ladders."""
    keys = [key for variation in deck.convergence.variants for key in variation.keys]
    return {key: changes[key] for key in keys}


def observed(before: dict[str, Any], size: float, error: dict[str, float | None]) -> dict[str, float | None]:
    """Orders between a level and the one before; None where an error is zero or not there."""
    found: dict[str, float | None] = {}
    for name, value in error.items():
        previous = before["errors"][name]
        found[name] = orders([before["size"], size], [previous, value])[0] if previous and value else None
    return found


def limits_of(deck: ConvergenceDeck, rows: list[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """The Richardson limits of the scalars of one ladder."""
    sizes = [row["size"] for row in rows]
    for name in deck.convergence.scalars:
        values = [row["scalars"][name] for row in rows]
        if None not in values:
            limit = richardson(sizes, values, deck.convergence.order)
            yield {
                "variant": rows[0]["variant"],
                "scalar": name,
                "limit": limit.value,
                "error": limit.error,
                "order": limit.order,
            }


def missed(deck: ConvergenceDeck, rows: list[dict[str, Any]], limits: list[dict[str, Any]]) -> Iterator[str]:
    """Sentences on what the deck expects and the study has not found."""
    least, largest = deck.expect.order, deck.expect.limit_error
    for variant, ladder in groupby(rows, key=lambda row: row["variant"]):
        order = last_order(list(ladder))
        if least is not None and (order is None or order < least):
            said = "no order" if order is None else f"the order {order:.3f}"
            yield f"{said_of(variant)}{said} of the errors is found, {least:g} or more is expected"
    for entry in limits:
        if largest is not None and not entry["error"] <= largest * abs(entry["limit"]):
            bar = f"{entry['limit']:.6g} +- {entry['error']:.2g}"
            where = f"{said_of(entry['variant'])}{entry['scalar']}"
            yield f"{where} tends to {bar}, a relative error bar of {largest:g} or less is expected"


def last_order(rows: list[dict[str, Any]]) -> float | None:
    """The order of the sum of errors between the two finest levels that have one."""
    found = [row["orders"][TOTAL] for row in rows if row["errors"][TOTAL] is not None]
    return found[-1] if found else None


def said_of(variant: Changes) -> str:
    """A variant in words, with a colon; nothing for the only one."""
    return f"{', '.join(map(str, variant.values()))}: " if variant else ""


def flat(row: dict[str, Any]) -> dict[str, Any]:
    """A row of the table."""
    return {
        **row["changes"],
        "cells": row["cells"],
        "dt": row["dt"],
        "size": row["size"],
        **{f"error_{name}": value for name, value in row["errors"].items()},
        **{f"order_{name}": value for name, value in row["orders"].items()},
        **row["scalars"],
        "folder": row["folder"],
    }


def scalars(summary: dict[str, Any]) -> dict[str, Any]:
    """Numbers that describe the study: the last order and the first limit of its first ladder."""
    rows, limits = summary["rows"], summary["limits"]
    first = [row for row in rows if row["variant"] == rows[0]["variant"]]
    limit = limits[0] if limits else {"limit": None, "error": None}
    return {**summary, "order": last_order(first), "limit": limit["limit"], "limit_error": limit["error"]}


def describe(deck: ConvergenceDeck) -> list[str]:
    """Lines on what will be run, for `check`: the levels, and the scales of the finest."""
    members = members_of(deck)
    for ladder in ladders(deck, members):
        check_nested([member.deck for member in ladder], deck.convergence.reference)
    levels = [", ".join(f"{key} = {value}" for key, value in member.changes.items()) for member in members]
    finest = members[-1].deck
    return [*levels, f"the last of these {len(members)} runs:", *KINDS[finest.kind].describe(finest)]


def closing(summary: dict[str, Any]) -> list[str]:
    """The table and the limits."""
    lines = []
    for row in summary["rows"]:
        error, order = row["errors"][TOTAL], row["orders"][TOTAL]
        numbers = "  ".join(f"{name} {value:.6g}" for name, value in row["scalars"].items())
        lines.append(
            f"{said_of(row['variant'])}{row['cells'][0]} x {row['cells'][1]}"
            + ("" if row["dt"] is None else f", dt {row['dt']:.3g}")
            + ("" if error is None else f": error {error:.3e}")
            + ("" if order is None else f", order {order:.2f}")
            + (f";  {numbers}" if numbers else "")
        )
    for entry in summary["limits"]:
        order = "no order" if entry["order"] is None else f"order {entry['order']:.2f}"
        bar = f"{entry['limit']:.6g} +- {entry['error']:.1g}"
        lines.append(f"{said_of(entry['variant'])}{entry['scalar']} tends to {bar}, {order}")
    return [*lines, f"{summary['wall_seconds']:.1f} s"]


KIND = Kind(solve, describe, closing, scalars, resume=solve)
