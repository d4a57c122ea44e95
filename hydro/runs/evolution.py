"""`kind = "evolution"`: from a deck to a folder with its run."""

from __future__ import annotations

import contextlib
import math
import resource
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from hydro.deck import EvolutionDeck, dumps
from hydro.deck.evolution import RunDeck
from hydro.deck.initial import CheckpointInitial
from hydro.dynamics import INTEGRATORS
from hydro.dynamics.integrator import Integrator, StepRejected
from hydro.errors import Complaint, DeckError, HydroError, RunFailed
from hydro.initial import initial_state
from hydro.mesh import Mesh
from hydro.runs.checkpoint import Checkpoint, read_checkpoint, write_checkpoint
from hydro.runs.folder import RunFolder
from hydro.runs.frames import Frames
from hydro.runs.march import Run, Tracker, march
from hydro.runs.observables import snapshot
from hydro.runs.trackers import AtTimes, History, ProgressBar, ProgressLines, StopOnSignal
from hydro.runs.xdmf import Series
from hydro.setup import wall_of
from hydro.state import State

MOST_PANELS = 12


def solve(deck: EvolutionDeck, folder: RunFolder, quiet: bool = False) -> dict[str, Any]:
    """Run the deck in its folder; returns the summary.

    Nothing in the folder is touched before the initial state is there and all is compiled. A HydroError on the
    way (failure, signal) comes through after the last good state has been saved.
    """
    with contextlib.ExitStack() as stack:
        stop = stack.enter_context(StopOnSignal())
        refuse_own_checkpoint(deck, folder)
        state, wall = initial_state(deck), wall_of(deck)
        integrator = integrator_of(deck, state)
        compile_seconds = warm_up(integrator, state)
        folder.prepare(dumps(deck))
        run = Run(state, integrator, deck.time.end, deck.time.dt_max or math.inf)
        keeper = Keeper(deck, folder, wall, state.mesh)
        trackers: list[Tracker] = [
            AtTimes(keeper.snapshot, deck.output_times),
            AtTimes(keeper.checkpoint, every=deck.output.checkpoint_every),
            History(folder.history, wall, deck.history_interval),
            stop,
        ]
        if deck.output.movie:
            trackers.append(Frames(folder.frames, deck.movie_interval, state.time))
        if not quiet:
            trackers.append(stack.enter_context(progress(folder.path.name, run.end)))
        try:
            march(run, trackers)
        except HydroError as error:
            keeper.finish(run, compile_seconds, completed=False)
            raise type(error)(f"{error}\nthe last good state is saved in {keeper.latest}") from error
        summary = keeper.finish(run, compile_seconds, completed=True)
    if deck.output.movie:
        close_with_movie(deck, folder, quiet)
    return summary


def close_with_movie(deck: RunDeck, folder: RunFolder, quiet: bool) -> None:
    """Make the movie of a run that is complete; RunFailed says so if that fails."""
    from hydro.runs.movie import make_movie  # matplotlib is slow to import

    try:
        make_movie(deck, folder, quiet)
    except (HydroError, OSError) as error:
        raise RunFailed(f"the run is complete and saved in {folder.path}, but not its movie: {error}") from error


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


def refuse_own_checkpoint(deck: EvolutionDeck, folder: RunFolder) -> None:
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
    name = deck.time.integrator
    return INTEGRATORS[name](state.gas, wall_of(deck), state.mesh, tau=deck.gas.tau, **OPTIONS[name](deck))


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

    def __init__(self, deck: EvolutionDeck, folder: RunFolder, wall: Any, mesh: Mesh):
        self.deck, self.folder, self.wall = deck, folder, wall
        self.snapshots: list[dict[str, float]] = []
        self._files: list[Path] = []  # of the snapshots
        self._series = Series(folder.series, folder.checkpoints, mesh)
        self.latest = Path()
        self._saved_at = -math.inf
        self._count = 0

    def snapshot(self, run: Run) -> None:
        """Note the observables, save a checkpoint and draw the density."""
        self.snapshots.append(snapshot(run.state, self.wall))
        self.checkpoint(run)
        self._files.append(self.latest)
        self._draw_density([run.state], self.snapshots[-1:], f"density_{self._count:04d}")

    def checkpoint(self, run: Run) -> None:
        """Save the state, once for each time."""
        if self._saved_at == run.state.time:
            return
        self._count += 1
        self._saved_at = run.state.time
        state = run.state
        saved = Checkpoint(
            state.mesh, state.conserved, state.time, run.steps, run.rejected, run.dt_limit,
            run.ledger.entries(), run.integrator.memory(), dumps(self.deck),
        )  # fmt: skip
        self.latest = self.folder.checkpoints / f"{self._count:04d}_t{state.time:g}.h5"
        write_checkpoint(self.latest, saved)
        self._series.update()

    def finish(self, run: Run, compile_seconds: float, completed: bool) -> dict[str, Any]:
        """Save the last state, draw the pictures of the whole run, write the summary and return it."""
        seconds = run.wall_seconds
        self.checkpoint(run)
        if self.snapshots:
            self._draw_snapshots(run.state)
        self._draw_history()
        summary = {**self._summary(run, seconds, completed), "compile_seconds": compile_seconds}
        self.folder.write_summary(summary)
        return summary

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
            "wall_seconds": seconds,
            "cell_updates_per_second": run.steps * state.density.size / seconds,
            "peak_memory_bytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
            "mass_drift": state.mass / run.ledger.initial_mass - 1.0,
            "energy_ledger": run.ledger.balance(state.energy),
            "snapshots": self.snapshots,
        }

    def _draw_snapshots(self, like: State) -> None:
        """Density maps and profiles of the snapshots, or of as many of them as fit into one picture."""
        from hydro.pictures.profiles import profiles  # matplotlib is slow to import

        which = np.unique(np.linspace(0, len(self._files) - 1, MOST_PANELS).astype(int)).tolist()
        saved = [read_checkpoint(self._files[k]) for k in which]
        states = [State(like.gas, like.mesh, moment.conserved, moment.time) for moment in saved]
        self._draw_density(states, [self.snapshots[k] for k in which], "density")
        profiles(self.folder.pictures / "profiles.png", states)

    def _draw_density(self, states: list[State], snapshots: list[dict[str, float]], name: str) -> None:
        from hydro.pictures.density import Map, density_panels

        maps = [
            Map(state.density, state.mesh, f"$t={state.time:g}$", row["wall_max"], row["wall_min"])
            for state, row in zip(states, snapshots, strict=True)
        ]
        density_panels(self.folder.pictures / f"{name}.png", maps)

    def _draw_history(self) -> None:
        from hydro.pictures.history import history_curves

        rows = np.genfromtxt(self.folder.history, delimiter=",", names=True)
        if rows.size > 1:
            history_curves(self.folder.pictures / "history.png", rows)
