"""The main loop and its trackers."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

import hydro
from hydro.driver.march import Run, choose_step
from hydro.driver.trackers import AtTimes
from hydro.dynamics import Godunov, Integrator, StepRejected
from hydro.errors import RunFailed
from hydro.gas import Grossman
from hydro.mesh import Mesh
from hydro.state import State
from hydro.walls import VibratingWall


class Counter(Integrator):
    """An integrator of fixed step that refuses steps above `allowed`."""

    step_limits = ("sound",)

    def __init__(self, largest: float, allowed: float = math.inf):
        self.largest, self.allowed, self.taken = largest, allowed, []

    def limits(self, state):
        return {"sound": self.largest}

    def step(self, state, dt):
        if dt > self.allowed:
            raise StepRejected("too far")
        self.taken.append(dt)
        state.time += dt
        return {}


def a_run(integrator, end):
    return Run(State.of(Grossman(0.0, 0.0), Mesh.rectangle((4, 4)), 0.1, 1.0), integrator, end)


def test_output_times_are_hit_exactly_without_slivers():
    run, seen = a_run(Counter(0.3), 2.0), []
    run.march([AtTimes(lambda now: seen.append(now.state.time), (0.0, 0.1, 0.95, 2.0), every=0.5)])
    assert seen == [0.0, 0.1, 0.5, 0.95, 1.0, 1.5, 2.0]
    assert min(run.integrator.taken) >= 0.05 - 1e-15


def test_rejected_steps_are_halved_and_counted():
    run = a_run(Counter(0.4, allowed=0.15), 1.0)
    run.march([])
    assert run.state.time == 1.0 and max(run.integrator.taken) <= 0.15 and run.rejected > 0


def test_a_run_that_cannot_step_fails_with_the_reason():
    with pytest.raises(RunFailed, match="too far"):
        a_run(Counter(0.4, allowed=0.0), 1.0).march([])


@pytest.mark.parametrize(("largest", "remaining", "expected"), [(1.0, 0.5, 0.5), (1.0, 1.5, 0.75), (1.0, 9.0, 1.0)])
def test_choose_step(largest, remaining, expected):
    assert choose_step(largest, remaining) == expected


def test_tracker_of_times_survives_an_inexact_cadence():
    tracker, seen = AtTimes(lambda run: seen.append(run.state.time), every=0.1), []
    time = 0.0
    while time < 1.05:
        tracker.look(SimpleNamespace(state=SimpleNamespace(time=time)))
        time = tracker.next_stop(time)
    assert len(seen) == 10 and seen == pytest.approx(np.arange(1, 11) * 0.1)


def test_march_is_the_loop_of_runs():
    gas, mesh = Grossman(5e4, 2e-3), Mesh.rectangle((8, 16), 2.0)
    state = State.of(gas, mesh, 0.0235, 1.0)
    energy, seen = state.energy, []
    run = hydro.march(state, Godunov(gas, VibratingWall(114.0), mesh), 0.1, [AtTimes(seen.append, (0.05,))])
    assert state.time == 0.1 and len(seen) == 1 and seen[0] is run and run.state is state
    assert run.steps > 2 and sum(run.set_by.values()) == run.steps
    assert run.ledger.initial_energy == energy and abs(run.ledger.balance(state.energy)["residual"]) < 1e-12
    again = State.of(gas, mesh, 0.0235, 1.0)
    Run(again, Godunov(gas, VibratingWall(114.0), mesh), 0.1).march([AtTimes(lambda run: None, (0.05,))])
    np.testing.assert_array_equal(again.conserved, state.conserved)
