"""Packed, cold gas: its balance of internal energy, and collisions that lose nothing."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from hydro.deck import load
from hydro.driver.march import march
from hydro.dynamics import Godunov, LagrangeRemap
from hydro.gas import Grossman
from hydro.gas.elastic import inelastic_share, inelastic_share_slope
from hydro.initial import initial_state
from hydro.mesh import Mesh
from hydro.setup import elastic_below, integrator_of
from hydro.state import State
from hydro.walls import ElasticWall

PROBLEMS = Path(__file__).parents[1] / "problems"
GAS = Grossman(5e4, 2e-3)
PRESSURE = 4e-3


def moving_core(gas: Grossman, speed: float) -> State:
    """A packed core at the pressure of a driven gas, which moves through a periodic box as a whole."""
    mesh = Mesh.rectangle((16, 32), 2.0, 1.0, (True, True))
    x, y = 2.0 * math.pi * mesh.x[:, None], math.pi * mesh.y[None, :]
    n = 0.99 + 0.008 * np.cos(x) * np.cos(y)
    velocity = speed * np.ones_like(n), 0.5 * speed * np.ones_like(n)
    return State.of(gas, mesh, n, gas.temperature(n, PRESSURE), velocity)


def test_a_packed_core_that_moves_keeps_its_pressure():
    """Its kinetic energy is a hundred times its heat; errors of the former must not make the latter."""
    gas = Grossman(0.0, 0.0)
    state = moving_core(gas, 0.1)
    assert (0.5 * state.speed**2 / state.temperature).min() > 20.0
    mass, start, momentum = state.mass, state.energy, state.mesh.integral(state.conserved[1])
    run = march(state, LagrangeRemap(gas, ElasticWall(), state.mesh), 2.0)
    internal = run.ledger.amounts["internal"]
    assert state.pressure == pytest.approx(PRESSURE, rel=0.02)
    assert state.mass == pytest.approx(mass, rel=1e-13)
    assert state.mesh.integral(state.conserved[1]) == pytest.approx(momentum, rel=1e-5)
    assert state.energy - start == pytest.approx(internal, abs=1e-12 * start)
    assert 0.0 < abs(internal) < 1e-2 * start
    assert run.steps < 200


def test_cells_with_much_heat_or_at_the_speed_of_sound_keep_total_energy():
    gas = Grossman(0.0, 0.0)
    mesh = Mesh.rectangle((8, 8), 1.0, 1.0, (True, True))
    for n, T, speed in ((0.3, 0.1, 0.1), (0.3, 1e-4, 1.0)):
        state = State.of(gas, mesh, n, T, (np.full((8, 8), speed), np.zeros((8, 8))))
        integrator = LagrangeRemap(gas, ElasticWall(), mesh)
        assert march(state, integrator, 0.01).ledger.amounts["internal"] == 0.0
        assert not integrator._cold.any


@pytest.mark.parametrize("T", [1e-9, 1e-8, 3e-8, 1e-3])
def test_the_share_of_inelastic_collisions_and_its_slope(T):
    share = inelastic_share(T, 1e-8)
    assert share == pytest.approx(1.0 / (1.0 + (1e-8 / T) ** 4), rel=1e-14)
    step = 1e-5 * T
    difference = (inelastic_share(T + step, 1e-8) - inelastic_share(T - step, 1e-8)) / (2.0 * step)
    assert inelastic_share_slope(T, 1e-8) * T == pytest.approx(difference * T, rel=1e-6, abs=1e-9)
    assert inelastic_share(1e-3, 1e-8) == 1.0 == inelastic_share(T, 0.0)


@pytest.mark.parametrize("method", [Godunov, LagrangeRemap])
def test_gas_below_the_elastic_temperature_hardly_cools(method):
    """Uniform gas at rest: dT/dt = -q/n T^(3/2) T^4/(T^4 + T_e^4), so T^(-1/2) + T_e^4 T^(-9/2)/9 grows at q/(2n)."""
    mesh, n, start, T_e = Mesh.rectangle((8, 8)), 0.3, 1.0, 0.3
    state = State.of(GAS, mesh, n, start)
    rate = float(GAS.cooling_coefficient(n) / n)
    end = 40.0 / rate
    march(state, method(GAS, ElasticWall(), mesh, elastic_below=T_e), end)

    def clock(T):
        return 2.0 * T**-0.5 + T_e**4 * T**-4.5 / 4.5

    found = clock(float(state.temperature.mean())) - clock(start)
    assert found == pytest.approx(rate * end, rel=0.01)
    assert state.temperature.min() > 0.5 * T_e * 0.2


def test_a_box_that_stalled_runs_to_its_end():
    """f = 0.1, amplitude 0.9, as in `benchmarks/packed.py`: steps fell to 1e-3 and below."""
    deck = load(
        PROBLEMS / "fig4.toml",
        ["gas.K=2e-3", "gas.f=0.1", "gas.tau=20", "mesh.cells=[12,24]", "time.end=60", "initial.temperature=1.0",
         "initial.amplitude=0.9", "output.times=[]"],
    )  # fmt: skip
    state = initial_state(deck)
    run = march(state, integrator_of(deck, state), deck.time.end)
    assert run.steps < 3000 and state.temperature.min() > 0.0
    assert abs(run.ledger.balance(state.energy)["residual"]) < 1e-10


@pytest.mark.parametrize(
    ("name", "settings", "expected"),
    [("fig4", (), 1e-8), ("fig4", ("gas.elastic_below=0",), 0.0), ("cooling", (), 0.0), ("free_cooling", (), 0.0)],
)
def test_collisions_are_elastic_in_cold_gas_where_a_wall_heats_it(name, settings, expected):
    assert elastic_below(load(PROBLEMS / f"{name}.toml", settings)) == expected
