"""Small parts: registries, compiled closures, mesh, observables, books, the main loop."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest

from hydro.check.scales import largest_step
from hydro.choices import INTEGRATORS
from hydro.deck import parse
from hydro.driver.march import Run, advance, march
from hydro.driver.trackers import EachStep
from hydro.dynamics import Godunov, LagrangeRemap, StepRejected, multigrid
from hydro.gas import Grossman
from hydro.initial import initial_state
from hydro.initial.cosine import cosine_averages
from hydro.initial.regrid import regrid
from hydro.jit import kernel
from hydro.mesh import Mesh
from hydro.numerics.reduce import store_largest
from hydro.setup import integrator_of
from hydro.state import State
from hydro.steady.localized import steady_state
from hydro.terms import Friction, Viscosity
from hydro.walls import ThermalWall, VibratingWall


@kernel
def compiled_properties(gas, n, T, out):
    for k in range(n.size):
        out[0, k] = gas.pressure(n[k], T)
        out[1, k] = gas.sound_speed(n[k], T)
        out[2, k] = gas.conductivity(n[k], T)
        out[3, k] = gas.cooling(n[k], T)
        out[4, k] = gas.density(out[0, k], T)
        out[5, k], out[6, k] = gas.viscosities(n[k], T)


def test_closures_are_the_same_in_numpy_and_in_kernels():
    gas, n, T = Grossman(5e4, 2e-3), np.geomspace(1e-4, 0.999, 50), 0.37
    out = np.zeros((7, 50))
    compiled_properties(gas, n, T, out)
    p = gas.pressure(n, T)
    expected = [p, gas.sound_speed(n, T), gas.conductivity(n, T), gas.cooling(n, T), gas.density(p, T)]
    np.testing.assert_allclose(out[:5], expected, rtol=1e-13)
    assert np.all(np.abs(out[5:] - gas.viscosities(n, T)) <= 1e-13 * gas.conductivity(n, T))


USER_CLOSURE = """
from typing import NamedTuple
from hydro.dynamics import Godunov
from hydro.gas import Grossman
from hydro.methods import compiled_methods
from hydro.mesh import Mesh
from hydro.check.scales import largest_step
from hydro.state import State

@compiled_methods
class GivenFlux(NamedTuple):
    flux: float

    def face(self, gas, n, T, half_width, guess):
        return self.flux, T

gas, mesh = Grossman(0.0, 1e-3), Mesh.rectangle((8, 8))
state = State.of(gas, mesh, 0.1, 1.0)
print(Godunov(gas, GivenFlux(0.25), mesh).step(state, 1e-3)["wall"])
"""


def test_a_wall_written_in_a_script_runs_and_disturbs_nobody(tmp_path):
    script = tmp_path / "my_wall.py"
    script.write_text(USER_CLOSURE)
    printed = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True).stdout
    assert float(printed) == pytest.approx(0.25e-3, rel=1e-13)
    gas, mesh = Grossman(0.0, 1e-3), Mesh.rectangle((8, 8))
    fresh = (
        "from hydro.dynamics import *; from hydro.gas import *; from hydro.mesh import *; from hydro.state import *\n"
        "from hydro.walls import *\n"
        "gas, mesh = Grossman(0.0, 1e-3), Mesh.rectangle((8, 8))\n"
        "print(Godunov(gas, VibratingWall(strength=1e-3), mesh).step(State.of(gas, mesh, 0.1, 1.0), 1e-3)['wall'])"
    )
    other = subprocess.run([sys.executable, "-c", fresh], capture_output=True, text=True, check=True).stdout
    wall, state = VibratingWall(strength=1e-3), State.of(gas, mesh, 0.1, 1.0)
    assert float(other) == Godunov(gas, wall, mesh).step(state, 1e-3)["wall"]


def test_a_stretched_mesh_fills_the_box_smoothly():
    mesh = Mesh.rectangle((64, 8), 2.0, 20.0)
    assert mesh.x_faces[0] == 0.0 and mesh.x_faces[-1] == pytest.approx(1.0, abs=1e-15)
    assert mesh.dx[-1] / mesh.dx[0] == pytest.approx(20.0 ** (63 / 64), rel=1e-12)
    assert mesh.integral(np.ones(mesh.cells)) == pytest.approx(2.0, rel=1e-14)


def a_cluster(mesh, steepness=30.0):
    """A dense corner in uniform pressure, a little flow, on any mesh."""
    gas = Grossman(0.0, 0.0)
    r = np.hypot(mesh.x[:, None], mesh.y[None, :])
    n = 0.004 + 0.75 / (1.0 + np.exp(steepness * (r - 0.4)))
    return State.of(gas, mesh, n, gas.temperature(n, 0.004), (0.01 * n, 0.02))


@pytest.mark.parametrize("steepness", [30.0, 1e9])
def test_regrid_conserves_and_keeps_bounds_and_pressure(steepness):
    with np.errstate(over="ignore"):
        old = a_cluster(Mesh.rectangle((48, 96), 2.0), steepness)
    moved = regrid(old, Mesh.rectangle((40, 130), 2.0, 4.0))
    for before, after in zip(old.conserved, moved.conserved, strict=True):
        assert moved.mesh.integral(after) == pytest.approx(old.mesh.integral(before), rel=1e-12)
    assert old.density.min() * (1.0 - 1e-11) <= moved.density.min()
    assert moved.density.max() <= old.density.max() * (1.0 + 1e-11)
    assert np.ptp(moved.pressure) < 1e-10 * moved.pressure.mean()


def test_regrid_converges_and_keeps_an_unchanged_mesh():
    old = a_cluster(Mesh.rectangle((16, 24), 2.0))
    np.testing.assert_array_equal(regrid(old, Mesh.rectangle((16, 24), 2.0)).conserved, old.conserved)
    errors = []
    for nx in (32, 64, 128):
        there = a_cluster(Mesh.rectangle((nx, 2 * nx), 2.0), 10.0)
        target = Mesh.rectangle((3 * nx // 4, nx), 2.0, 2.0)
        wanted = a_cluster(target, 10.0)
        errors.append(np.abs(regrid(there, target).density - wanted.density).mean())
    assert errors[0] / errors[1] > 3.0 and errors[1] / errors[2] > 3.0


def test_a_nan_of_either_sign_is_the_largest():
    out = np.zeros(3)
    for i, odd in enumerate((np.nan, -np.nan, 2.0)):
        largest_of(np.array([1.0, odd, 0.5]), out, i)
    assert np.isnan(out[0]) and np.isnan(out[1]) and out[2] == 2.0


@kernel
def largest_of(values, out, i):
    store_largest(values, out, i)


@pytest.mark.parametrize(
    ("cold", "K", "L"), [(1e-2, 2e-3, 5e4), (1e-4, 2e-3, 5e4), (1e-6, 2e-3, 5e4), (1e-3, 0.2, 5e4)]
)
def test_cold_gas_beside_a_hot_wall_loses_heat_and_does_not_overshoot(cold, K, L):
    gas, mesh = Grossman(L, K), Mesh.rectangle((32, 8))
    state = State.of(gas, mesh, 0.0235, cold)
    losses, hottest = [], []

    def watch(run):
        losses.append(run.ledger.amounts["collisions"])
        hottest.append(run.state.temperature.max())

    march(state, Godunov(gas, ThermalWall(1.0), mesh), 0.5, [EachStep(watch)])
    assert np.all(np.diff(losses) > 0.0)
    assert max(hottest) < 1.0


def test_a_rejected_step_leaves_no_trace():
    gas, mesh = Grossman(5e4, 2e-3), Mesh.rectangle((8, 16), 2.0)
    state = State.of(gas, mesh, 0.1, 1.0)
    integrator = Godunov(gas, VibratingWall(strength=0.228), mesh)
    integrator.step(state, 1e-3)
    before, memory = state.copy(), integrator.memory()
    with pytest.raises(StepRejected):
        integrator.step(state, 1e3)
    np.testing.assert_array_equal(state.conserved, before.conserved)
    np.testing.assert_array_equal(integrator.memory()["wall_temperature"], memory["wall_temperature"])
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


@pytest.mark.parametrize(("n", "T", "W"), [(0.004, 1.0, 114.0), (0.6, 1e-5, 114.0), (0.99, 1e-3, 1e4), (0.3, 1.0, 0.0)])
def test_the_vibrating_wall_balances_heat_also_against_cold_dense_gas(n, T, W):
    """A strong wall against dense gas: the heat given first grows with the wall's temperature."""
    gas, half_width = Grossman(1e6, 0.1), 1.0 / 32.0
    flux, wall = VibratingWall(strength=gas.K * W).face(gas, n, T, half_width, T)
    face = gas.density(gas.pressure(n, T), wall)
    conducted = 0.5 * (gas.conductivity(n, T) + gas.conductivity(face, wall)) * (wall - T) / half_width
    assert wall >= T and face <= n
    assert flux == pytest.approx(gas.K * W * face * np.sqrt(wall), rel=1e-12, abs=1e-300)
    assert conducted == pytest.approx(flux, rel=1e-7, abs=1e-12)


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
    copy = state.copy()
    second.remember(first.memory())
    for integrator, each in ((first, state), (second, copy)):
        for _ in range(5):
            integrator.step(each, integrator.largest_step(each))
    np.testing.assert_array_equal(state.conserved, copy.conserved)


@pytest.mark.parametrize(("wave", "sign"), [(0, 1.0), (1, -1.0), (2, 1.0), (3, -1.0)])
def test_cosines_are_even_or_odd_to_the_last_bit(wave, sign):
    cosine = cosine_averages(Mesh.rectangle((2, 50), 1.3), wave)
    np.testing.assert_array_equal(cosine, sign * cosine[::-1])
    assert np.abs(cosine).max() > 0.99


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
        if key not in ("velocity", "wall_temperature"):  # set anew at the start of each step, and a first guess
            np.testing.assert_array_equal(values, memory[key])
    with pytest.raises(ValueError, match="two or more"):
        LagrangeRemap(gas, wall, Mesh.rectangle((8, 1)))


@pytest.mark.parametrize("stretch", [1.0, 5.0])
@pytest.mark.parametrize("periodic", [(False, False), (False, True), (True, True)])
def test_multigrid_solves_the_equations_of_the_implicit_step(stretch, periodic):
    """Cycles under exact residuals end in the solution that a sparse solver finds."""
    rng = np.random.default_rng(5)
    hierarchy = multigrid.Hierarchy(Mesh.rectangle((12, 10), 1.3, stretch, periodic))
    finest = hierarchy.levels[0]
    finest.local[:] = rng.uniform(0.1, 0.2, finest.local.shape) * np.array([1.0, -0.3, 0.3, 1.0])[:, None]
    for axis, faces in enumerate((finest.faces_x, finest.faces_y)):
        faces[:, :3] = rng.uniform(0.5, 1.0, faces[:, :3].shape)
        faces[:, 3:] = 0.05 * rng.standard_normal(faces[:, 3:].shape)
        if not periodic[axis]:
            faces[0 if axis == 0 else (slice(None), slice(None), 0)] = 0.0
    multigrid.build(*finest.equations())
    hierarchy.prepare()
    matrix = multigrid.dense(finest)
    wanted = rng.standard_normal(finest.right.size)
    right, found = matrix @ wanted, np.zeros(finest.right.size)
    for _ in range(25):
        finest.right[:] = (right - matrix @ found).reshape(finest.right.shape)
        hierarchy.cycle()
        found += finest.unknowns[:, :, 1:-1].reshape(-1)
    assert found == pytest.approx(wanted, rel=1e-5, abs=1e-5)


def test_iterations_of_the_implicit_step_do_not_grow_with_the_grid():
    """A dense cluster, n from 0.004 to 0.9995, at steps of many times what heat and sound take to cross it."""
    gas, wall, counts = Grossman(L=5e4, K=2e-3), VibratingWall(strength=0.228), []
    for nx in (32, 64, 128):
        state = steady_state(gas, wall, Mesh.rectangle((nx, 2 * nx), 2.0), 0.04, 1).state
        warmer = state.temperature * (1.0 + 0.01 * cosine_averages(state.mesh, 3))
        state = State.of(gas, state.mesh, state.density, warmer)
        integrator = LagrangeRemap(gas, wall, state.mesh, terms=[Friction(200.0)], tolerance=1e9)
        run = Run(state, integrator, math.inf, dt_max=10.0)
        for _ in range(30):
            advance(run, math.inf)
        before = integrator.iterations
        for _ in range(10):
            advance(run, math.inf)
        counts.append((integrator.iterations - before) / 10)
    assert max(counts) <= 8.0 and counts[-1] <= 1.3 * counts[0]
