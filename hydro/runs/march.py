"""The main loop."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

from hydro.dynamics.integrator import Integrator, StepRejected
from hydro.errors import RunFailed
from hydro.runs.ledger import Ledger
from hydro.state import State

HALVINGS = 12  # of a rejected step, before the run gives up


@dataclass
class Run:
    """A run under way: its state, how it is advanced, and its books."""

    state: State
    integrator: Integrator
    end: float
    dt_max: float = math.inf
    steps: int = 0
    rejected: int = 0
    dt: float = 0.0
    dt_limit: float = math.inf  # after a rejection; doubles with each accepted step
    ledger: Ledger = field(init=False)
    started: float = field(default_factory=time.perf_counter)

    def __post_init__(self) -> None:
        self.ledger = Ledger(self.state.energy, self.state.mass)

    @property
    def wall_seconds(self) -> float:
        return time.perf_counter() - self.started


class Tracker(Protocol):
    """Looks at a run before its first step and after each; owns a side effect, such as files or progress."""

    def next_stop(self, time: float) -> float:
        """The next time after `time` that a step must end at; infinite if none matters."""

    def look(self, run: Run) -> None:
        """Act, if it is time to."""


def march(run: Run, trackers: Sequence[Tracker]) -> None:
    """Advance `run` to its end; RunFailed when no step is possible, with the state as it was then."""
    for tracker in trackers:
        tracker.look(run)
    while run.state.time < run.end:
        stop = min([run.end, *(tracker.next_stop(run.state.time) for tracker in trackers)])
        advance(run, stop)
        for tracker in trackers:
            tracker.look(run)


def advance(run: Run, stop: float) -> None:
    """One accepted step, not beyond `stop`; a rejected one is tried again with half the step."""
    largest = min(run.integrator.largest_step(run.state), run.dt_max, run.dt_limit)
    dt = choose_step(largest, stop - run.state.time)
    reason = "the sound speed is infinite"
    for _ in range(HALVINGS):
        if not dt > 0.0 or run.state.time + dt == run.state.time:
            break
        lands = run.state.time + dt >= stop
        try:
            exchange = run.integrator.step(run.state, dt)
        except StepRejected as rejection:
            run.rejected, dt, reason = run.rejected + 1, 0.5 * dt, str(rejection)
            run.dt_limit = dt
            continue
        run.state.time = stop if lands else run.state.time
        run.ledger.book(exchange)
        run.steps, run.dt, run.dt_limit = run.steps + 1, dt, 2.0 * run.dt_limit
        return
    raise RunFailed(f"no step is possible at t = {run.state.time:.6g}, down to dt = {dt:.3g}: {reason}")


def choose_step(largest: float, remaining: float) -> float:
    """The largest step, or less so that the remaining time is not left with a sliver."""
    if largest >= remaining:
        return remaining
    return 0.5 * remaining if 2.0 * largest > remaining else largest
