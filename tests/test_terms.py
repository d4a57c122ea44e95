"""Terms of the equations: what is added by one file and one line acts in both integrators, and in the books."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from hydro import march
from hydro.accounts import Account
from hydro.choices import TERMS
from hydro.deck.evolution import EvolutionDeck, with_terms
from hydro.driver.march import Run, advance
from hydro.dynamics import Godunov, LagrangeRemap
from hydro.gas import Grossman
from hydro.mesh import Mesh
from hydro.registry import Entry, Registry
from hydro.schema import Number, Section
from hydro.state import State
from hydro.terms import Friction, Term
from hydro.walls import ElasticWall

INTEGRATORS = [Godunov, LagrangeRemap]
LIFT = Account("lift", 1, "work of the lift")


class Lift(Term):
    """A constant force along x and y."""

    account = LIFT

    def __init__(self, x: float, y: float = 0.0):
        self.force = np.array([x, y])

    @classmethod
    def of(cls, deck: Any) -> Lift | None:
        return None if deck.lift is None else cls(deck.lift.x, deck.lift.y)

    def acceleration(self, time: float, state: State) -> np.ndarray:
        return self.force[:, None, None] * np.ones(state.mesh.cells)


class LiftSection(Section):
    """A constant force per mass."""

    x: Number = 0.0
    y: Number = 0.0


class Slow(Term):
    """Allows no step longer than this."""

    def largest_step(self, state: State) -> float:
        return 1e-4


def gas_at_rest(periodic: tuple[bool, bool]) -> State:
    mesh = Mesh.rectangle((8, 12), 1.5, periodic=periodic)
    return State.of(Grossman(0.0, 0.0), mesh, 0.2, 1.0)


@pytest.mark.parametrize("method", INTEGRATORS)
def test_a_constant_force_moves_the_whole_gas_as_newton_says(method):
    """In a periodic box the gas falls freely: v = g t exactly, and the work is the kinetic energy."""
    state = gas_at_rest((True, True))
    run = Run(state, method(state.gas, ElasticWall(), state.mesh, [Lift(0.3, -0.2)]), 0.5)
    before = state.energy
    while state.time < run.end:
        advance(run, run.end)
    u, v = state.velocity
    assert u == pytest.approx(0.15, rel=1e-12) and v == pytest.approx(-0.1, rel=1e-12)
    booked = run.ledger.balance(state.energy)
    assert booked["lift"] == pytest.approx(0.5 * 0.2 * 1.5 * (0.15**2 + 0.1**2), rel=1e-3)
    assert booked["lift"] == pytest.approx(state.energy - before, rel=1e-10)
    assert state.temperature == pytest.approx(1.0, rel=1e-3)


@pytest.mark.parametrize("method", INTEGRATORS)
def test_a_force_toward_a_wall_presses_the_gas_on_it(method):
    """With friction the gas comes to rest, the pressure grows toward the wall by the weight, and the books close.

    Beside the walls the mirror images of the explicit integrator know nothing of the weight.
    """
    state = gas_at_rest((False, True))
    run = Run(state, method(state.gas, ElasticWall(), state.mesh, [Lift(0.2), Friction(0.1)]), 6.0)
    while state.time < run.end:
        advance(run, run.end)
    weight = np.diff(state.pressure.mean(axis=1)) / (1.0 / 8.0)
    middle = 0.5 * (state.density[1:] + state.density[:-1]).mean(axis=1)
    assert weight[1:-1] == pytest.approx(0.2 * middle[1:-1], rel=0.02)
    assert abs(run.ledger.balance(state.energy)["residual"]) < 1e-12


def test_a_term_limits_the_step_and_is_named_where_steps_are_counted():
    state = gas_at_rest((True, True))
    for method in INTEGRATORS:
        run = Run(state.copy(), method(state.gas, ElasticWall(), state.mesh, [Slow()]), 3e-4)
        while run.state.time < run.end:
            advance(run, run.end)
        assert run.dt <= 1e-4 and run.set_by["slow"] >= 1


def test_drag_of_two_terms_adds_and_is_booked_under_one_account():
    state = State.of(Grossman(0.0, 0.0), Mesh.rectangle((8, 8), periodic=(True, True)), 0.2, 1.0, (0.5, 0.0))
    march(state, Godunov(state.gas, ElasticWall(), state.mesh, [Friction(2.0), Friction(1.0)]), 1.0)
    assert state.velocity[0] == pytest.approx(0.5 * math.exp(-1.5), rel=1e-12)


def test_a_section_beside_a_term_is_a_section_of_decks(monkeypatch):
    """What a deck says under the name of a term reaches the term."""
    entries = {**TERMS._entries, "lift": Entry(f"{__name__}:Lift", section=f"{__name__}:LiftSection")}
    table: Registry[Any] = Registry("term", entries)
    monkeypatch.setattr("hydro.deck.evolution.TERMS", table)
    monkeypatch.setattr("hydro.setup.TERMS", table)
    model = with_terms(EvolutionDeck)
    given = {
        "kind": "evolution",
        "gas": {"L": 0.0, "f": 0.2, "K": 0.0},
        "mesh": {"cells": [8, 8]},
        "wall": {"kind": "elastic"},
        "initial": {"kind": "uniform"},
        "time": {"end": 1.0},
    }
    from hydro.setup import terms_of

    without, lifted = model.model_validate(given), model.model_validate(given | {"lift": {"y": 0.4}})
    assert not [term for term in terms_of(without) if isinstance(term, Lift)]
    (lift,) = (term for term in terms_of(lifted) if isinstance(term, Lift))
    assert lift.force.tolist() == [0.0, 0.4]


class Unbooked(Lift):
    account = None


class Misshapen(Lift):
    def acceleration(self, time: float, state: State) -> np.ndarray:
        return np.ones(state.mesh.cells[0])


@pytest.mark.parametrize("method", INTEGRATORS)
def test_a_force_without_an_account_acts_and_one_of_another_shape_is_refused(method):
    state = gas_at_rest((True, True))
    march(state, method(state.gas, ElasticWall(), state.mesh, [Unbooked(0.3)]), 0.1)
    assert state.velocity[0] == pytest.approx(0.03, rel=1e-12)
    with pytest.raises(ValueError, match=r"Misshapen gives a field of shape \(8,\); \(2, 8, 12\) is wanted"):
        method(state.gas, ElasticWall(), state.mesh, [Misshapen(0.3)]).step(state, 1e-3)
