"""Both integrators: rejected steps, memory, symmetry, threads."""

from __future__ import annotations

from pathlib import Path

import numba
import numpy as np
import pytest
from conftest import go_on_alike

from hydro.check.scales import largest_step
from hydro.choices import INTEGRATORS
from hydro.deck import parse
from hydro.dynamics import Godunov, LagrangeRemap, StepRejected
from hydro.gas import Grossman
from hydro.initial import initial_state
from hydro.mesh import Mesh
from hydro.setup import integrator_of
from hydro.state import State
from hydro.terms import Friction, Viscosity
from hydro.walls import VibratingWall


def test_a_rejected_step_leaves_no_trace():
    gas, mesh = Grossman(5e4, 2e-3), Mesh.rectangle((8, 16), 2.0)
    state = State.of(gas, mesh, 0.1, 1.0)
    integrator = Godunov(gas, VibratingWall(strength=0.228), mesh)
    integrator.step(state, 1e-3)
    before, memory = state.copy(), integrator.memory()
    with pytest.raises(StepRejected):
        integrator.step(state, 1e3)
    np.testing.assert_array_equal(state.conserved, before.conserved)
    for key, values in integrator.memory().items():
        np.testing.assert_array_equal(values, memory[key])
    assert state.time == before.time


def test_a_step_out_of_proportion_to_the_cooling_time_is_rejected_at_once():
    gas, mesh = Grossman(5e8, 1.0), Mesh.rectangle((4, 4))
    state = State.of(gas, mesh, 0.9, 1.0)
    with pytest.raises(StepRejected, match="too fast for dt = 1"):
        Godunov(gas, VibratingWall(strength=0.0), mesh).step(state, 1.0)


def test_a_mesh_of_one_cell_between_walls_is_refused():
    with pytest.raises(ValueError, match="between walls"):
        Godunov(Grossman(0.0, 0.0), VibratingWall(strength=0.0), Mesh.rectangle((8, 1)))


def test_a_step_keeps_the_arrays_of_its_state():
    gas, mesh = Grossman(0.0, 0.0), Mesh.rectangle((8, 8))
    state = State.of(gas, mesh, 0.1, 1.0)
    array = state.conserved
    Godunov(gas, VibratingWall(strength=0.0), mesh).step(state, 1e-3)
    assert state.conserved is array


def test_check_and_integrator_agree_on_the_first_step():
    deck = parse(Path(__file__).parent.parent.joinpath("problems", "noise.toml").read_text(encoding="utf-8"))
    state = initial_state(deck)
    assert largest_step(deck, state) == pytest.approx(integrator_of(deck, state).largest_step(state), rel=1e-12)


def test_the_number_of_threads_does_not_change_a_bit():
    gas, mesh = Grossman(5e4, 2e-3), Mesh.rectangle((96, 128), 2.0, 3.0)
    noise = 1.0 + 0.1 * np.random.default_rng(0).uniform(-1.0, 1.0, mesh.cells)
    results, threads = [], numba.get_num_threads()
    for count in (1, threads):
        numba.set_num_threads(count)
        state = State.of(gas, mesh, 0.05 * noise, 1.0)
        integrator = Godunov(gas, VibratingWall(strength=0.228), mesh, terms=[Friction(200.0)])
        for _ in range(20):
            integrator.step(state, integrator.largest_step(state))
        results.append((integrator.threads, state.conserved))
    numba.set_num_threads(threads)
    assert results[-1][0] == min(threads, 3)
    np.testing.assert_array_equal(results[0][1], results[-1][1])


@pytest.mark.parametrize("viscosity", [0.0, 1.0])
@pytest.mark.parametrize("name", list(INTEGRATORS))
def test_an_integrator_that_remembers_goes_on_with_the_same_bits(name, viscosity):
    gas, wall, mesh = Grossman(L=5e4, K=2e-3), VibratingWall(strength=0.228), Mesh.rectangle((8, 16), 2.0)
    state = State.of(gas, mesh, 0.0235 * (1.0 + 0.1 * np.cos(np.pi * mesh.y)), 1.0)
    first, second = (
        INTEGRATORS[name](gas, wall, mesh, terms=[Friction(200.0), Viscosity(viscosity)]) for _ in range(2)
    )
    for _ in range(5):
        first.step(state, first.largest_step(state))
    assert go_on_alike(first, second, state)


@pytest.mark.parametrize("viscosity", [0.0, 1.0])
@pytest.mark.parametrize("cells", [(16, 32), (12, 50), (9, 11), (12, 7)])
def test_mirror_images_stay_so_to_the_last_bit_by_the_implicit_integrator(cells, viscosity):
    """Also where a number of cells is odd on some level of the multigrid."""
    gas, wall, mesh = Grossman(L=5e4, K=2e-3), VibratingWall(strength=0.228), Mesh.rectangle(cells, 2.0)
    noise = np.random.default_rng(3).uniform(-0.01, 0.01, (4, *cells))
    sign = np.array([1.0, 1.0, -1.0, 1.0])[:, None, None]  # the velocity in y changes its own

    def image(fields):
        return sign * fields[:, :, ::-1]

    n, u, v, T = noise + image(noise)
    state = State.of(gas, mesh, 0.0235 * (1.0 + n), 1.0 + T, (0.1 * u, 0.1 * v))
    integrator = LagrangeRemap(gas, wall, mesh, terms=[Friction(200.0), Viscosity(viscosity)])
    for _ in range(20):
        integrator.step(state, integrator.largest_step(state))
    assert np.ptp(state.density, axis=1).min() > 0.0
    np.testing.assert_array_equal(state.conserved, image(state.conserved))


def test_the_implicit_integrator_rejects_a_change_beyond_its_tolerance():
    gas, wall, mesh = Grossman(L=5e4, K=2e-3), VibratingWall(strength=0.228), Mesh.rectangle((8, 16), 2.0)
    state = State.of(gas, mesh, 0.0235 * (1.0 + 0.1 * np.cos(np.pi * mesh.y)), 1.0)
    integrator = LagrangeRemap(gas, wall, mesh, terms=[Friction(200.0)])
    integrator.step(state, 1e-3)
    before, memory = state.copy(), integrator.memory()
    with pytest.raises(StepRejected, match="the change not foreseen is"):
        integrator.step(state, 0.5)
    np.testing.assert_array_equal(state.conserved, before.conserved)
    for key, values in integrator.memory().items():
        if not key.startswith(
            ("velocity", "wall_temperature")
        ):  # set anew at the start of each step, and a first guess
            np.testing.assert_array_equal(values, memory[key])
    with pytest.raises(ValueError, match="two or more"):
        LagrangeRemap(gas, wall, Mesh.rectangle((8, 1)))
