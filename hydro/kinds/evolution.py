"""`kind = "evolution"`: from a deck to a folder with its run."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable
from typing import Any

from hydro.deck import EvolutionDeck
from hydro.driver.history import History
from hydro.driver.keeper import Keeper
from hydro.driver.march import Run
from hydro.driver.run_in_folder import Engine, go_on, restore, start, state_of
from hydro.dynamics import INTEGRATORS
from hydro.dynamics.integrator import Integrator
from hydro.errors import StepRejected
from hydro.exact.evolution import sources_of
from hydro.observables import OBSERVABLES
from hydro.output.checkpoint import Checkpoint
from hydro.output.folder import RunFolder
from hydro.setup import terms_of, wall_of
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
    run = Run(state, integrator, deck.time.end, deck.time.dt_max or math.inf)
    if saved is not None:
        restore(run, saved)
    return run, compile_seconds


def closing(summary: dict[str, Any]) -> list[str]:
    """The snapshots, and how the run went."""
    seen = OBSERVABLES[summary["observables"]]
    return [
        *map(seen.closing_line, summary["snapshots"]),
        f"{summary['steps']} steps ({summary['rejected_steps']} rejected) in {summary['wall_seconds']:.1f} s; "
        f"mass drift {summary['mass_drift']:.1e}, energy residual {summary['energy_ledger']['residual']:.1e}",
    ]


def scalars(summary: dict[str, Any]) -> dict[str, Any]:
    """Numbers that describe the run: those of its last snapshot among them."""
    rows = summary["snapshots"]
    return {**summary, **(rows[-1] if rows else {}), "drift": OBSERVABLES[summary["observables"]].drift(rows)}


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


EVOLUTION = Engine(begin, Keeper, History)
