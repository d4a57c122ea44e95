"""What a run leaves in its folder: snapshots, checkpoints, pictures and the summary."""

from __future__ import annotations

import math
import resource
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from hydro.choices import STATE_PICTURES
from hydro.deck import dumps
from hydro.driver.march import Run
from hydro.errors import HydroError, NoStep, RunFailed
from hydro.mesh import Mesh
from hydro.observables import Observables
from hydro.output.checkpoint import Checkpoint, read_or_skip, write_checkpoint
from hydro.output.files import sync
from hydro.output.folder import RunFolder
from hydro.output.history import read_rows
from hydro.output.xdmf import Series
from hydro.revision import git_revision
from hydro.state import State, refuse_inadmissible

MOST_PANELS = 12
KEPT = 2  # checkpoints by wall clock or signal: one more than needed, for the newest may get damaged


class Keeper:
    """Keeps what a run leaves behind: snapshots, checkpoints, pictures and the summary."""

    def __init__(
        self,
        deck: Any,
        folder: RunFolder,
        observables: Observables,
        wall: Any,
        mesh: Mesh,
        saved: Checkpoint | None = None,
    ):
        self.deck, self.folder, self.observables, self.wall = deck, folder, observables, wall
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
        self.note(run, {**self.observables.snapshot(run.state, self.wall), **run.reading})

    def note(self, run: Run, observed: dict[str, Any]) -> None:
        """Note what was observed of a run, draw the density, and save a checkpoint to keep."""
        row: dict[str, Any] = {**observed, "checkpoint": self._path(run).name}
        self.snapshots.append(row)
        if self.deck.output.pictures:
            self._draw_density([self.seen(run)], f"density_{len(self.snapshots):04d}")
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
        self.inspect(run)
        replaceable = replaceable and all(row["checkpoint"] != path.name for row in self.snapshots)
        names = [*self._replaceable, path.name] if replaceable else self._replaceable
        kept = names[-(self.deck.output.keep or KEPT) :]
        saved = run.checkpoint(dumps(self.deck))
        words = saved.words | {"snapshots": self.observables.words | run.ledger.words}
        write_checkpoint(path, replace(saved, snapshots=self.snapshots, replaceable=names, words=words))
        for name in names[: -len(kept)]:
            (self.folder.checkpoints / name).unlink(missing_ok=True)
        self._replaceable = kept
        self._series.update()

    def inspect(self, run: Run) -> None:
        """RunFailed for a state that is not to be saved: that of no gas, whatever has led to it."""
        refuse_inadmissible(run.state)

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
        except (OSError, ValueError, HydroError) as worse:
            lines.append(f"not all could be saved: {worse}")
        if saved := self.folder.saved():
            lines.append(f"the last good state is saved in {saved[-1]}")
            lines += self.otherwise(run) if isinstance(error, NoStep) else [self.restart(error)]
        return kind("\n".join(lines))

    def restart(self, error: HydroError | OSError) -> str:
        """How to go on from the newest checkpoint."""
        words = ["python -m hydro restart", str(self.folder.path), getattr(error, "remedy", "")]
        return f"to go on from it: {' '.join(filter(None, words))}"

    def otherwise(self, run: Run) -> list[str]:
        """What has helped runs that came to where no step is possible: to begin otherwise."""
        helpful = [remedy.change for remedy in run.integrator.remedies if remedy.is_new(self.deck)]
        anew = f"python -m hydro {self.folder.deck}"
        commands = [f"  {anew} {change} --output {self.folder.path}_{k}" for k, change in enumerate(helpful, 1)]
        told = ["what has helped such runs is to begin otherwise:", *commands] if helpful else []
        return ["a restart would end there at once", *told]

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
            **run.integrator.counts(),
            **run.reading,
            **run.integrator.resolution(),
            "wall_seconds": seconds,
            "cell_updates_per_second": run.steps * state.density.size / seconds,
            "peak_memory_bytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
            "mass_drift": state.mass / run.ledger.initial_mass - 1.0,
            "energy_ledger": run.ledger.balance(state.energy),
            "observables": self.observables.name,
            "snapshots": self.snapshots,
        }

    def _draw_snapshots(self, like: State) -> None:
        """Density maps and profiles of the snapshots, or of as many of them as fit into one picture."""
        if not self.snapshots:
            return
        which = np.unique(np.linspace(0, len(self.snapshots) - 1, MOST_PANELS).astype(int)).tolist()
        saved = [read_or_skip(self.folder.checkpoints / self.snapshots[k]["checkpoint"]) for k in which]
        states = [self.shown(like, moment) for moment in saved if moment is not None]
        if states:
            self._draw_density(states, "density")
            self._draw_profiles(states)
            for name in self.observables.drawn:
                STATE_PICTURES[name](self.folder.pictures / f"{name}.png", states)

    def seen(self, run: Run) -> State:
        """What pictures and frames show of a run."""
        return run.state

    def shown(self, like: State, saved: Checkpoint) -> State:
        """What pictures show of a checkpoint; its gas and mesh are those of `like`."""
        return State(like.gas, like.mesh, saved.conserved, saved.time)

    def _draw_density(self, states: list[State], name: str) -> None:
        from hydro.pictures.density import Map, density_panels

        note = self.observables.span.note
        maps = [
            Map(state.density, state.mesh, f"$t={state.time:g}$", note(state.density, state.mesh)) for state in states
        ]
        density_panels(self.folder.pictures / f"{name}.png", maps)

    def _draw_profiles(self, states: list[State]) -> None:
        from hydro.pictures.profiles import profiles  # matplotlib is slow to import

        profiles(self.folder.pictures / "profiles.png", states)

    def _draw_history(self) -> None:
        from hydro.pictures.history import history_curves

        rows = read_rows(self.folder.history)
        if len(rows) > 1:
            history_curves(self.folder.pictures / "history.png", rows, self.observables.panels)
