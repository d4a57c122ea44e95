"""`kind = "evolution"`: from a deck to a folder with its run."""

from __future__ import annotations

import contextlib
import math
import resource
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hydro.deck import EvolutionDeck, dumps
from hydro.deck.evolution import RunDeck
from hydro.deck.initial import CheckpointInitial
from hydro.driver.history import History, read_rows
from hydro.driver.march import Run, Tracker, march
from hydro.driver.restart import newest_checkpoint, refuse_changes
from hydro.driver.trackers import AtTimes, Every, ProgressBar, ProgressLines, SaveOnSignal, StopOnSignal, WallLimit
from hydro.dynamics import INTEGRATORS
from hydro.dynamics.integrator import Integrator
from hydro.errors import CheckpointError, Complaint, DeckError, HydroError, RunFailed, StepRejected
from hydro.exact.evolution import sources_of
from hydro.initial import initial_state
from hydro.mesh import Mesh
from hydro.movies.frames import Frames
from hydro.observables.clustering import QUANTITIES, snapshot
from hydro.output.checkpoint import Checkpoint, read_or_skip, write_checkpoint
from hydro.output.files import sync
from hydro.output.folder import RunFolder
from hydro.output.xdmf import Series
from hydro.revision import git_revision
from hydro.setup import gas_of, terms_of, wall_of
from hydro.state import State

MOST_PANELS = 12
KEPT = 2  # checkpoints by wall clock or signal: one more than needed, for the newest may get damaged


def solve(deck: EvolutionDeck, folder: RunFolder, quiet: bool = False) -> dict[str, Any]:
    """Run the deck in its folder, which holds no other run then; returns the summary.

    Nothing in the folder is touched before the initial state is there and all is compiled. A HydroError on the
    way (failure, signal) comes through after the last good state has been saved.
    """
    return start(EVOLUTION, deck, folder, quiet)


def resume(deck: EvolutionDeck, folder: RunFolder, quiet: bool = False) -> dict[str, Any]:
    """Go on with the run in a folder, from its newest checkpoint, to the end that `deck` names; returns the summary.

    With the same deck it ends in the same bits as if it had not been interrupted. DeckError if the deck is that of
    another problem, CheckpointError if there are checkpoints but none can be read; else as `solve`.
    """
    return go_on(EVOLUTION, deck, folder, quiet)


class Engine(NamedTuple):
    """What a kind of run in time has of its own."""

    begin: Callable[[Any, Checkpoint | None], tuple[Run, float]]  # the run, compiled, and the seconds that took
    keeper: type[Keeper]
    history: type[History]


def start(engine: Engine, deck: RunDeck, folder: RunFolder, quiet: bool) -> dict[str, Any]:
    """Run a deck from its initial state; see `solve`."""
    refuse_own_checkpoint(deck, folder)
    return _follow(engine, deck, folder, None, quiet)


def go_on(engine: Engine, deck: RunDeck, folder: RunFolder, quiet: bool) -> dict[str, Any]:
    """Run a deck from the newest checkpoint in its folder; see `resume`."""
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
    return _follow(engine, deck, folder, saved, quiet)


def _follow(engine: Engine, deck: RunDeck, folder: RunFolder, saved: Checkpoint | None, quiet: bool) -> dict[str, Any]:
    """The run from its initial state, or from a checkpoint of it, to its end."""
    with contextlib.ExitStack() as stack:
        stop, limit = stack.enter_context(StopOnSignal()), WallLimit(deck.time.wall_limit)
        run, compile_seconds = engine.begin(deck, saved)
        wall, began = wall_of(deck), run.state.time
        folder.prepare(dumps(deck), keep=saved is not None)
        keeper = engine.keeper(deck, folder, wall, run.state.mesh, saved)
        trackers: list[Tracker] = [
            AtTimes(keeper.snapshot, deck.output_times, done=keeper.last_snapshot),
            AtTimes(keeper.cadence, every=deck.output.checkpoint_every),
            engine.history(folder.history, wall, deck.history_interval, began),
            Every(keeper.safety, deck.output.checkpoint_seconds),
            stack.enter_context(SaveOnSignal(keeper.safety)),
            stop,
            limit,
        ]
        if deck.output.movie:
            trackers.append(Frames(folder.frames, deck.movie_interval, began, keeper.seen))
        if not quiet:
            trackers.append(stack.enter_context(progress(folder.path.name, run.end)))
        try:
            march(run, trackers)
            summary = keeper.finish(run, compile_seconds, completed=True)
        except (HydroError, OSError) as error:
            raise keeper.rescue(run, compile_seconds, error) from error
    if deck.output.movie:
        close_with_movie(deck, folder, quiet)
    return summary


def begin(deck: EvolutionDeck, saved: Checkpoint | None) -> tuple[Run, float]:
    """The gas in its initial state or in that of a checkpoint, its kernels compiled, and the seconds that took."""
    state = state_of(deck, saved)
    integrator = integrator_of(deck, state)
    compile_seconds = warm_up(integrator, state)
    run = Run(state, integrator, deck.time.end, deck.time.dt_max or math.inf)
    if saved is not None:
        restore(run, saved)
    return run, compile_seconds


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


def closing(summary: dict[str, Any]) -> list[str]:
    """The snapshots, and how the run went."""
    ledger = summary["energy_ledger"]
    rows = [
        f"t={row['time']:<8g} wall max {row['wall_max']:.4f}  min {row['wall_min']:.4f}  "
        f"gas {row['gas_density']:.5f}  Mach {row['max_mach']:.1e}"
        for row in summary["snapshots"]
    ]
    return [
        *rows,
        f"{summary['steps']} steps ({summary['rejected_steps']} rejected) in {summary['wall_seconds']:.1f} s; "
        f"mass drift {summary['mass_drift']:.1e}, energy residual {ledger['residual']:.1e}",
    ]


def scalars(summary: dict[str, Any]) -> dict[str, Any]:
    """Numbers that describe the run: those of its last snapshot among them."""
    seen = summary["snapshots"]
    return {**summary, **(seen[-1] if seen else {}), "drift": drift(seen)}


def drift(snapshots: list[dict[str, Any]]) -> float | None:
    """How fast the wall densities still change: the largest of |d log n/dt| between the last two snapshots."""
    if len(snapshots) < 2:
        return None
    before, after = snapshots[-2:]
    changes = [abs(math.log(after[key] / before[key])) for key in ("wall_max", "wall_min")]
    return max(changes) / (after["time"] - before["time"])


def refuse_own_checkpoint(deck: RunDeck, folder: RunFolder) -> None:
    """DeckError if the run would replace the checkpoint that it starts from."""
    initial = deck.initial
    if isinstance(initial, CheckpointInitial) and Path(initial.path).resolve().is_relative_to(folder.path.resolve()):
        problem = f"{initial.path} lies in the folder that this run would replace; choose another with --output"
        raise DeckError([Complaint("initial.path", problem)], "output folder")


# What integrators take from a deck beside gas, wall, mesh and friction.
OPTIONS: dict[str, Callable[[EvolutionDeck], dict[str, Any]]] = {
    "godunov": lambda deck: {"cfl": deck.time.cfl, "limiter": deck.scheme.limiter, "riemann": deck.scheme.riemann},
    "lagrange-remap": lambda deck: {
        "cfl": deck.time.cfl,
        "limiter": deck.scheme.limiter,
        "tolerance": deck.time.tolerance,
    },
}


def integrator_of(deck: EvolutionDeck, state: State) -> Integrator:
    """The deck's integrator, ready for `state`."""
    name, options = deck.time.integrator, OPTIONS[deck.time.integrator](deck)
    terms = [*terms_of(deck), *sources_of(deck)]
    return INTEGRATORS[name](state.gas, wall_of(deck), state.mesh, terms, **options)


def warm_up(integrator: Integrator, state: State) -> float:
    """Compile, or load, all kernels by a step that leaves no trace; returns the seconds that took."""
    started, memory = time.perf_counter(), integrator.memory()
    with contextlib.suppress(StepRejected):
        integrator.step(state.copy(), 1e-3 * integrator.largest_step(state))
    integrator.remember(memory)
    return time.perf_counter() - started


def progress(title: str, end: float) -> ProgressBar | ProgressLines:
    """A bar on a terminal, lines elsewhere."""
    return ProgressBar(title, end) if sys.stderr.isatty() else ProgressLines(title, end)


class Keeper:
    """Keeps what a run leaves behind: snapshots, checkpoints, pictures and the summary."""

    def __init__(self, deck: Any, folder: RunFolder, wall: Any, mesh: Mesh, saved: Checkpoint | None = None):
        self.deck, self.folder, self.wall = deck, folder, wall
        self.snapshots = [] if saved is None else list(saved.snapshots)
        self._replaceable = [] if saved is None else list(saved.replaceable)
        self._series = Series(folder.series, folder.checkpoints, mesh)
        if saved is not None:
            self._series.update()
        git_revision()  # of the source that runs, whatever happens to it from now on

    @property
    def last_snapshot(self) -> float:
        """When the last snapshot was taken; minus infinity before the first."""
        return self.snapshots[-1]["time"] if self.snapshots else -math.inf

    def snapshot(self, run: Run) -> None:
        """Note the observables, draw the density, and save a checkpoint to keep."""
        self.note(run, snapshot(run.state, self.wall))

    def note(self, run: Run, observed: dict[str, Any]) -> None:
        """Note what was observed of a run, draw the density, and save a checkpoint to keep."""
        row: dict[str, Any] = {**observed, "checkpoint": self._path(run).name}
        self.snapshots.append(row)
        if self.deck.output.pictures:
            self._draw_density([self.seen(run)], [row], f"density_{len(self.snapshots):04d}")
        self._save(run, replaceable=False)

    def cadence(self, run: Run) -> None:
        """Save a checkpoint, to keep unless the deck wants only so many."""
        self._save(run, replaceable=self.deck.output.keep is not None)

    def safety(self, run: Run) -> None:
        """Save a checkpoint that newer ones will replace."""
        self._save(run, replaceable=True)

    def _save(self, run: Run, replaceable: bool) -> None:
        """Save the state, once for each step, and remove what it replaces."""
        path = self._path(run)
        if path.exists():
            return
        if self.folder.history.exists():
            sync(self.folder.history)  # rows up to a checkpoint shall not be lost where it is not
        replaceable = replaceable and all(row["checkpoint"] != path.name for row in self.snapshots)
        names = [*self._replaceable, path.name] if replaceable else self._replaceable
        kept = names[-(self.deck.output.keep or KEPT) :]
        saved = run.checkpoint(dumps(self.deck))
        words = saved.words | {"snapshots": QUANTITIES}
        write_checkpoint(path, replace(saved, snapshots=self.snapshots, replaceable=names, words=words))
        for name in names[: -len(kept)]:
            (self.folder.checkpoints / name).unlink(missing_ok=True)
        self._replaceable = kept
        self._series.update()

    def _path(self, run: Run) -> Path:
        return self.folder.checkpoints / f"{run.steps:08d}_t{run.state.time:g}.h5"

    def finish(self, run: Run, compile_seconds: float, completed: bool) -> dict[str, Any]:
        """Save the last state, draw the pictures of the whole run, write the summary and return it."""
        seconds = run.wall_seconds
        self._save(run, replaceable=not completed)
        if self.deck.output.pictures:
            self._draw_snapshots(run.state)
            self._draw_history()
        summary = {**self._summary(run, seconds, completed), "compile_seconds": compile_seconds}
        self.folder.write_summary(summary)
        return summary

    def rescue(self, run: Run, compile_seconds: float, error: HydroError | OSError) -> HydroError:
        """Save what can be saved of a run that cannot go on; returns the error to raise, which says where it is."""
        kind = type(error) if isinstance(error, HydroError) else RunFailed
        lines = [str(error)]
        try:
            self.finish(run, compile_seconds, completed=False)
        except (OSError, ValueError) as worse:
            lines.append(f"not all could be saved: {worse}")
        if saved := self.folder.saved():
            lines.append(f"the last good state is saved in {saved[-1]}")
            words = ["python -m hydro restart", str(self.folder.path), getattr(error, "remedy", "")]
            lines.append(f"to go on from it: {' '.join(filter(None, words))}")
        return kind("\n".join(lines))

    def _summary(self, run: Run, seconds: float, completed: bool) -> dict[str, Any]:
        state = run.state
        return {
            "kind": self.deck.kind,
            "completed": completed,
            "cells": list(state.mesh.cells),
            "integrator": self.deck.time.integrator,
            "tolerance": self.deck.time.tolerance,
            "time": state.time,
            "steps": run.steps,
            "rejected_steps": run.rejected,
            "steps_by": run.set_by,
            "wall_seconds": seconds,
            "cell_updates_per_second": run.steps * state.density.size / seconds,
            "peak_memory_bytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
            "mass_drift": state.mass / run.ledger.initial_mass - 1.0,
            "energy_ledger": run.ledger.balance(state.energy),
            "snapshots": self.snapshots,
        }

    def _draw_snapshots(self, like: State) -> None:
        """Density maps and profiles of the snapshots, or of as many of them as fit into one picture."""
        if not self.snapshots:
            return
        which = np.unique(np.linspace(0, len(self.snapshots) - 1, MOST_PANELS).astype(int)).tolist()
        rows = [self.snapshots[k] for k in which]
        saved = [read_or_skip(self.folder.checkpoints / row["checkpoint"]) for row in rows]
        states = [self.shown(like, moment) for moment in saved if moment is not None]
        if states:
            there = [row for row, moment in zip(rows, saved, strict=True) if moment is not None]
            self._draw_density(states, there, "density")
            self._draw_profiles(states)

    def seen(self, run: Run) -> State:
        """What pictures and frames show of a run."""
        return run.state

    def shown(self, like: State, saved: Checkpoint) -> State:
        """What pictures show of a checkpoint; its gas and mesh are those of `like`."""
        return State(like.gas, like.mesh, saved.conserved, saved.time)

    def _draw_density(self, states: list[State], snapshots: list[dict[str, Any]], name: str) -> None:
        from hydro.pictures.density import Map, density_panels

        maps = [
            Map(state.density, state.mesh, f"$t={state.time:g}$", row["wall_max"], row["wall_min"])
            for state, row in zip(states, snapshots, strict=True)
        ]
        density_panels(self.folder.pictures / f"{name}.png", maps)

    def _draw_profiles(self, states: list[State]) -> None:
        from hydro.pictures.profiles import profiles  # matplotlib is slow to import

        profiles(self.folder.pictures / "profiles.png", states)

    def _draw_history(self) -> None:
        from hydro.pictures.history import history_curves

        rows = read_rows(self.folder.history)
        if rows.size > 1:
            history_curves(self.folder.pictures / "history.png", rows)


EVOLUTION = Engine(begin, Keeper, History)
