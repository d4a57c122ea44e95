"""A run in time in its folder: begun or gone on with, followed by its trackers, and closed."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from hydro.deck import dumps
from hydro.deck.evolution import RunDeck
from hydro.driver.frames import Frames
from hydro.driver.history import History
from hydro.driver.keeper import Keeper
from hydro.driver.march import Run, Tracker
from hydro.driver.restart import newest_checkpoint, refuse_changes
from hydro.driver.trackers import AtReadings, AtTimes, Every, SaveOnSignal, ShowProgress, StopOnSignal, WallLimit
from hydro.errors import CheckpointError, Complaint, DeckError, HydroError, RunFailed
from hydro.initial import initial_state
from hydro.initial.checkpoint import FromCheckpoint
from hydro.observables import observables_of
from hydro.output.checkpoint import Checkpoint
from hydro.output.folder import RunFolder
from hydro.progress import progress
from hydro.setup import gas_of, wall_of
from hydro.state import State


class Engine(NamedTuple):
    """What a kind of run in time has of its own: how it begins, what it keeps, and its history."""

    begin: Callable[[Any, Checkpoint | None], tuple[Run, float]]  # the run, compiled, and the seconds that took
    keeper: type[Keeper]
    history: type[History]


def start(engine: Engine, deck: RunDeck, folder: RunFolder, quiet: bool) -> dict[str, Any]:
    """Run a deck from its initial state; returns the summary.

    Nothing in the folder, which holds no other run then, is touched before the initial state is there and all is
    compiled. A HydroError on the way (failure, signal) comes through after the last good state has been saved.
    """
    refuse_own_checkpoint(deck, folder)
    return follow(engine, deck, folder, None, quiet)


def go_on(engine: Engine, deck: RunDeck, folder: RunFolder, quiet: bool) -> dict[str, Any]:
    """Run a deck from the newest checkpoint in its folder; returns the summary.

    With the same deck it ends in the same bits as if it had not been interrupted. DeckError if the deck is that of
    another problem, CheckpointError if there are checkpoints but none can be read; else as `start`.
    """
    saved = newest_checkpoint(folder)
    if saved is None:
        print("hydro: no checkpoint was saved yet: the run begins anew", file=sys.stderr)
        return start(engine, deck, folder, quiet)
    refuse_changes(deck, saved)
    if deck.time.end < saved.time:
        problem = f"{deck.time.end:g} lies before the newest checkpoint, t = {saved.time:.6g}"
        raise DeckError([Complaint("time.end", problem)], "restart")
    if deck.time.end == saved.time and (summary := folder.read_summary()).get("completed"):
        print(f"hydro: complete at t = {saved.time:.6g}; a larger time.end takes it further", file=sys.stderr)
        return summary
    return follow(engine, deck, folder, saved, quiet)


def follow(engine: Engine, deck: RunDeck, folder: RunFolder, saved: Checkpoint | None, quiet: bool) -> dict[str, Any]:
    """The run from its initial state, or from a checkpoint of it, to its end."""
    with contextlib.ExitStack() as stack:
        stop, limit = stack.enter_context(StopOnSignal()), WallLimit(deck.time.wall_limit)
        run, compile_seconds = engine.begin(deck, saved)
        seen, wall, began = observables_of(deck), wall_of(deck), run.state.time
        folder.prepare(dumps(deck), keep=saved is not None)
        keeper = engine.keeper(deck, folder, seen, wall, run.state.mesh, saved)
        trackers: list[Tracker] = [
            AtTimes(keeper.snapshot, deck.output_times, done=keeper.last_snapshot),
            AtReadings(keeper.snapshot, getattr(deck.output, "collisions", ())),
            AtTimes(keeper.cadence, every=deck.output.checkpoint_every),
            engine.history(folder.history, seen, wall, deck.history_interval, began),
            Every(keeper.safety, deck.output.checkpoint_seconds),
            stack.enter_context(SaveOnSignal(keeper.safety)),
            stop,
            limit,
        ]
        if deck.output.movie:
            trackers.append(Frames(folder.frames, deck.movie_interval, began, keeper.seen))
        trackers.append(ShowProgress(stack.enter_context(progress(folder.path.name, run.end, quiet, began))))
        try:
            run.march(trackers)
            summary = keeper.finish(run, compile_seconds, completed=True)
        except (HydroError, OSError) as error:
            raise keeper.rescue(run, compile_seconds, error) from error
    if deck.output.movie:
        close_with_movie(deck, folder, quiet)
    return summary


def close_with_movie(deck: RunDeck, folder: RunFolder, quiet: bool) -> None:
    """Make the movie of a run that is complete; RunFailed says so if that fails."""
    from hydro.movies.movie import make_movie  # matplotlib is slow to import

    try:
        make_movie(deck, folder, quiet)
    except (HydroError, OSError) as error:
        raise RunFailed(f"the run is complete and saved in {folder.path}, but not its movie: {error}") from error


def state_of(deck: RunDeck, saved: Checkpoint | None) -> State:
    """The initial state, or that of a checkpoint."""
    return initial_state(deck) if saved is None else State(gas_of(deck), saved.mesh, saved.conserved, saved.time)


def restore(run: Run, saved: Checkpoint) -> None:
    """Take back books and memory from a checkpoint; CheckpointError if they are not those of this run."""
    try:
        run.restore(saved)
    except (KeyError, ValueError) as error:
        raise CheckpointError(f"the checkpoint at t = {saved.time:.6g} does not fit its deck ({error})") from error


def refuse_own_checkpoint(deck: RunDeck, folder: RunFolder) -> None:
    """DeckError if the run would replace the checkpoint that it starts from."""
    initial = deck.initial
    if isinstance(initial, FromCheckpoint) and Path(initial.path).resolve().is_relative_to(folder.path.resolve()):
        problem = f"{initial.path} lies in the folder that this run would replace; choose another with --output"
        raise DeckError([Complaint("initial.path", problem)], "output folder")
