"""Shocks by the implicit integrator, and that what is done for them leaves everything else alone."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import go_on_alike

from hydro.driver.march import march
from hydro.dynamics import LagrangeRemap
from hydro.dynamics.lagrange.shocks import Shocks, find_sound, find_violence, may_be_violent
from hydro.gas import Grossman
from hydro.mesh import Geometry, Mesh
from hydro.state import State
from hydro.terms.viscosity.artificial import BulkViscosity
from hydro.verification.implicit import driven, exact_wave, implicit, start_of_fig4
from hydro.verification.riemann_problems import HARD, calculate, random_problems
from hydro.verification.setups import ELASTIC, IDEAL, along, godunov
from hydro.verification.waves import simple_wave


@pytest.mark.parametrize("cells", [200, 400])
def test_a_mild_shock_has_no_spike_of_pressure(cells):
    assert calculate(HARD[0], 0, cells, implicit).overshoot < 0.02


@pytest.mark.parametrize("problem", HARD[1:], ids=lambda problem: problem.name)
def test_strong_shocks_dense_and_thin_gas_take_ordinary_steps(problem):
    outcome = calculate(problem, 1, 100, counting := Counting())
    assert counting.steps < 600
    assert outcome.error < 1.5 * calculate(problem, 1, 100, godunov).error


class Counting:
    """Makes integrators that count their steps."""

    def __init__(self):
        self.steps = 0

    def __call__(self, mesh):
        integrator = implicit(mesh)
        step = integrator.step

        def counted(state, dt):
            self.steps += 1
            return step(state, dt)

        integrator.step = counted
        return integrator


@pytest.fixture
def nothing_acts(monkeypatch):
    """Whatever is done for shocks is an error."""

    def refuse(*_):
        raise AssertionError("the gas is taken for rough")

    monkeypatch.setattr(BulkViscosity, "resist", refuse)


@pytest.mark.parametrize("cells", [8, 16, 24])
def test_the_start_of_fig4_is_smooth(cells, nothing_acts):
    state = start_of_fig4(cells)
    integrator = driven(state.mesh)
    march(state, integrator, 1.0)
    assert not integrator.memory()["shared"].any()


def test_a_resolved_wave_is_smooth_up_to_half_of_its_breaking_time(nothing_acts):
    mesh = along(0, 32, thickness=2)
    state = State(IDEAL, mesh, exact_wave(mesh, 0.0))
    integrator = implicit(mesh)
    march(state, integrator, 0.5 * simple_wave().breaking_time)
    assert not integrator.memory()["shared"].any()


def blast(mesh: Mesh) -> State:
    """Hot dense gas in the middle of thin gas, which moves along x; its own mirror image in y."""
    inside = (mesh.x[:, None] - 0.5) ** 2 + (mesh.y - 0.5) ** 2 < 0.04
    inside &= inside[:, ::-1]
    return State.of(IDEAL, mesh, np.where(inside, 0.4, 0.02), np.where(inside, 20.0, 0.5), (0.5, 0.0))


def test_a_blast_keeps_its_books_and_its_mirror_image_to_the_last_bit():
    mesh = Mesh.rectangle((24, 26), periodic=(True, True))
    state = blast(mesh)
    before = mesh.integral(state.conserved[1]), state.mass, state.energy
    integrator = LagrangeRemap(IDEAL, ELASTIC, mesh)
    run = march(state, integrator, 0.05)
    assert run.set_by["shock"] > 0
    assert integrator.memory()["shared"].all()
    n, u, v, e = state.conserved
    np.testing.assert_array_equal(np.array([n, u, -v, e])[:, :, ::-1], state.conserved)
    assert np.abs(v).max() > 0.1
    after = mesh.integral(u), state.mass, state.energy
    assert after == pytest.approx(before, rel=1e-12)


def test_both_directions_are_alike():
    mesh = Mesh.rectangle((20, 20), periodic=(True, True))
    corner = (mesh.x[:, None] + mesh.y < 0.8) & (np.abs(mesh.x[:, None] - mesh.y) < 0.3)
    states = []
    for swap in (False, True):
        hot = corner.T if swap else corner
        push = (0.0, 0.7) if swap else (0.7, 0.0)
        state = State.of(IDEAL, mesh, np.where(hot, 0.3, 0.05), np.where(hot, 8.0, 0.5), push)
        march(state, LagrangeRemap(IDEAL, ELASTIC, mesh), 0.05)
        states.append(state.conserved)
    swapped = states[1][[0, 2, 1, 3]].transpose(0, 2, 1)
    np.testing.assert_allclose(swapped, states[0], rtol=1e-6, atol=1e-8)


def test_a_run_with_shocks_goes_on_with_the_same_bits():
    gas, mesh = Grossman(L=0.0, K=0.0), Mesh.rectangle((16, 18), periodic=(True, True))
    state = blast(mesh)
    first, second = (LagrangeRemap(gas, ELASTIC, mesh) for _ in range(2))
    march(state, first, 0.02)
    assert go_on_alike(first, second, state)


def test_thin_gas_takes_the_velocity_of_the_dense_gas_beside_it():
    """Even shares would make the thin side hundreds of times as fast; what is left is the noise of a moving contact."""
    mesh = along(0, 32, thickness=2)
    n = np.where(np.abs(mesh.x[:, None] - 0.5) < 0.25, 0.3, 3e-4) * np.ones((1, 2))
    state = State.of(IDEAL, mesh, n, IDEAL.temperature(n, 1.0), (1.0, 0.0))
    march(state, LagrangeRemap(IDEAL, ELASTIC, mesh), 0.02)
    np.testing.assert_allclose(state.velocity[0], 1.0, atol=0.1)


def test_a_survey_is_made_once_for_a_state():
    mesh = Mesh.rectangle((8, 8), periodic=(True, True))
    integrator = LagrangeRemap(IDEAL, ELASTIC, mesh)
    state = blast(mesh)
    integrator.largest_step(state)
    shocks: Shocks = integrator._shocks
    rate, shocks.rate = shocks.rate, -1.0
    integrator.largest_step(state)
    assert shocks.rate == -1.0 != rate


def test_random_problems_have_solutions():
    problems = random_problems(3)
    assert [problem.name for problem in problems] == ["random 1", "random 2", "random 3"]
    assert all(problem.solution.pressure > 0.0 for problem in problems)


def test_the_quick_look_misses_no_violent_cell():
    """Random states, smooth to wild, with walls and without: what it calls smooth has no violent cell."""
    rng, found = np.random.default_rng(16), 0
    gas = Grossman(L=5e4, K=2e-3)
    for trial in range(400):
        mesh = Mesh.rectangle((5, 6), 1.0, 1.0, (bool(trial & 1), bool(trial & 2)))
        size = 10.0 ** rng.uniform(-3.0, 0.0)
        density = np.minimum(0.3 * np.exp(0.5 * size * rng.normal(size=mesh.cells)), 0.95)
        temperature, velocity = np.exp(size * rng.normal(size=mesh.cells)), size * rng.normal(size=(2, *mesh.cells))
        state = State.of(gas, mesh, density, temperature, tuple(velocity))
        pressure, sound, own, violence = (np.zeros(mesh.cells) for _ in range(4))
        find_sound(gas, state.conserved, pressure, sound)
        rate = find_violence(gas, Geometry.of(mesh), state.conserved, pressure, sound, own, violence)
        quick = may_be_violent(Geometry.of(mesh), state.conserved, pressure, sound)
        assert quick or (rate == 0.0 and not violence.any())
        found += quick and rate > 0.0
    assert 100 < found < 300
