"""The main loop."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

from hydro.accounts import Account
from hydro.driver.clock import Clock
from hydro.driver.ledger import Ledger
from hydro.dynamics.integrator import Integrator
from hydro.errors import NoStep, StepRejected
from hydro.output.checkpoint import Checkpoint
from hydro.state import State

HALVINGS = 12  # of a rejected step, before the run gives up
# What sets a step beside the limits of the integrator; output: a time that it must end at.
SET_BY = ("dt_max", "rejection", "output")


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
    clock: Clock | None = None
    set_by: dict[str, int] = field(init=False)  # numbers of steps by what set them
    ledger: Ledger = field(init=False)
    started: float = field(default_factory=time.perf_counter)
    seconds_before: float = 0.0  # that the run took until it was interrupted

    def __post_init__(self) -> None:
        self.set_by = dict.fromkeys((*self.integrator.step_limits, *SET_BY), 0)
        self.ledger = Ledger(self.accounts, self.state.energy, self.state.mass)
        self._rate = self.clock.rate(self.state) if self.clock else 0.0

    @property
    def accounts(self) -> tuple[Account, ...]:
        """Those of the integrator, and that of the clock."""
        return (*self.integrator.accounts, *((self.clock.account,) if self.clock else ()))

    @property
    def reading(self) -> dict[str, float]:
        """What the clock shows, by the name of its account; nothing without one."""
        return {self.clock.account.name: self.ledger.amounts[self.clock.account.name]} if self.clock else {}

    def tick(self, dt: float) -> None:
        """Let the clock go on by a step that has been made."""
        if self.clock:
            before, self._rate = self._rate, self.clock.rate(self.state)
            self.ledger.book({self.clock.account.name: 0.5 * dt * (before + self._rate)})

    @property
    def wall_seconds(self) -> float:
        return self.seconds_before + time.perf_counter() - self.started

    def checkpoint(self, deck: str) -> Checkpoint:
        """All that `restore` needs to go on from here with the same bits."""
        return Checkpoint(
            self.state.mesh, self.state.conserved, self.state.time, deck,
            steps=self.steps,
            rejected=self.rejected,
            dt=self.dt,
            dt_limit=self.dt_limit,
            wall_seconds=self.wall_seconds,
            set_by=self.set_by,
            ledger=self.ledger.entries(),
            memory=self.integrator.memory(),
            words={"ledger": self.ledger.words, "integrator": dict(self.integrator.remembered)},
        )  # fmt: skip

    def restore(self, saved: Checkpoint) -> None:
        """Take back books and memory of a run whose state is there already."""
        self.steps, self.rejected, self.dt, self.dt_limit = saved.steps, saved.rejected, saved.dt, saved.dt_limit
        self.set_by.update(saved.set_by)
        self.seconds_before = saved.wall_seconds
        self.ledger = Ledger.of(self.accounts, saved.ledger)
        self.integrator.remember(saved.memory)

    def march(self, trackers: Sequence[Tracker]) -> None:
        """Advance to the end; RunFailed when no step is possible, with the state as it was then."""
        for tracker in trackers:
            tracker.look(self)
        while self.state.time < self.end:
            stop = min([self.end, *(tracker.next_stop(self.state.time) for tracker in trackers)])
            advance(self, stop)
            for tracker in trackers:
                tracker.look(self)


class Tracker(Protocol):
    """Looks at a run before its first step and after each; owns a side effect, such as files or progress."""

    def next_stop(self, time: float) -> float:
        """The next time after `time` that a step must end at; infinite if none matters."""

    def look(self, run: Run) -> None:
        """Act, if it is time to."""


def march(state: State, integrator: Integrator, until: float, trackers: Sequence[Tracker] = ()) -> Run:
    """Advance `state` in place to the time `until`, in scaled units, with the steps that `integrator` allows.

    Trackers (see `hydro.driver.trackers`) look at the run before the first step and after each, and may ask that a step
    ends at a certain time. Steps that the integrator rejects are tried again with half their length. Returns the run:
    its `ledger` of energy, its number of `steps`, how many were `rejected`, and what set them (`set_by`). RunFailed
    when no step is possible, with the state as it was then.
    """
    run = Run(state, integrator, until)
    run.march(trackers)
    return run


def advance(run: Run, stop: float) -> None:
    """One accepted step, not beyond `stop`; a rejected one is tried again with half the step."""
    limits = {**run.integrator.limits(run.state), "dt_max": run.dt_max, "rejection": run.dt_limit}
    set_by = min(limits, key=limits.__getitem__)
    dt = choose_step(limits[set_by], stop - run.state.time)
    set_by = set_by if dt == limits[set_by] else "output"
    reason = "the sound speed is infinite"
    for _ in range(HALVINGS):
        if not dt > 0.0 or run.state.time + dt == run.state.time:
            break
        lands = run.state.time + dt >= stop
        try:
            amounts = run.integrator.step(run.state, dt)
        except StepRejected as rejection:
            run.rejected, dt, reason = run.rejected + 1, 0.5 * dt, str(rejection)
            run.dt_limit, set_by = dt, "rejection"
            continue
        run.state.time = stop if lands else run.state.time
        run.ledger.book(amounts)
        run.tick(dt)
        run.set_by[set_by] += 1
        run.steps, run.dt, run.dt_limit = run.steps + 1, dt, 2.0 * run.dt_limit
        return
    raise NoStep(f"no step is possible at t = {run.state.time:.6g}, down to dt = {dt:.3g}: {reason}")


def choose_step(largest: float, remaining: float) -> float:
    """The largest step, or less so that the remaining time is not left with a sliver."""
    if largest >= remaining:
        return remaining
    return 0.5 * remaining if 2.0 * largest > remaining else largest
