"""`kind = "evolution"`: from a deck to a folder with its run."""

from __future__ import annotations

import contextlib
import math
import time
from typing import Any

from hydro.check.scales import report
from hydro.deck import EvolutionDeck
from hydro.driver.clock import collision_clock
from hydro.driver.history import History
from hydro.driver.keeper import Keeper
from hydro.driver.march import Run
from hydro.driver.run_in_folder import Engine, go_on, restore, start, state_of
from hydro.dynamics.integrator import Integrator
from hydro.errors import StepRejected
from hydro.kinds.kind import Kind
from hydro.observables import observables_in
from hydro.output.checkpoint import Checkpoint
from hydro.output.folder import RunFolder
from hydro.setup import integrator_of
from hydro.state import State


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


def begin(deck: EvolutionDeck, saved: Checkpoint | None) -> tuple[Run, float]:
    """The gas in its initial state or in that of a checkpoint, its kernels compiled, and the seconds that took."""
    state = state_of(deck, saved)
    integrator = integrator_of(deck, state)
    compile_seconds = warm_up(integrator, state)
    run = Run(state, integrator, deck.time.end, deck.time.dt_max or math.inf, clock=collision_clock(deck))
    if saved is not None:
        restore(run, saved)
    return run, compile_seconds


def closing(summary: dict[str, Any]) -> list[str]:
    """The snapshots, and how the run went."""
    seen = observables_in(summary)
    return [
        *map(seen.closing_line, summary["snapshots"]),
        f"{summary['steps']} steps ({summary['rejected_steps']} rejected) in {summary['wall_seconds']:.1f} s; "
        f"mass drift {summary['mass_drift']:.1e}, energy residual {summary['energy_ledger']['residual']:.1e}",
        *unresolved(summary),
    ]


def unresolved(summary: dict[str, Any]) -> list[str]:
    """A line on sound that the steps did not resolve, if there was any."""
    if summary["sound_resolved"]:
        return []
    steps, amplitude, dt = (summary[key] for key in ("steps_per_sound_period", "unresolved_sound", "dt_for_sound"))
    return [
        f"sound of an amplitude of {amplitude:.1e} was not resolved and is damped by the scheme: "
        f"down to {steps:.1f} steps in the period of the slowest; time.dt_max = {dt:.2g} follows it"
    ]


def scalars(summary: dict[str, Any]) -> dict[str, Any]:
    """Numbers that describe the run: those of its last snapshot among them."""
    rows = summary["snapshots"]
    return {**summary, **(rows[-1] if rows else {}), "drift": observables_in(summary).drift(rows)}


def warm_up(integrator: Integrator, state: State) -> float:
    """Compile, or load, all kernels by a step that leaves no trace; returns the seconds that took."""
    started, memory = time.perf_counter(), integrator.memory()
    with contextlib.suppress(StepRejected):
        integrator.step(state.copy(), 1e-3 * integrator.largest_step(state))
    integrator.remember(memory)
    return time.perf_counter() - started


EVOLUTION = Engine(begin, Keeper, History)
KIND = Kind(solve, report, closing, scalars, resume)
