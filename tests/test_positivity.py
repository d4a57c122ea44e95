"""Cells stay admissible where the second-order update fails: fluxes of first order, spared stresses, and books."""

from __future__ import annotations

import numpy as np
import pytest

from hydro.dynamics import Godunov, StepRejected
from hydro.dynamics.limiters import VAN_LEER
from hydro.dynamics.riemann import HLLC_LOW_MACH, POSITIVE
from hydro.gas import Grossman
from hydro.mesh import Mesh
from hydro.state import State, inadmissible
from hydro.terms import Viscosity
from hydro.walls import ElasticWall

IDEAL = Grossman(L=0.0, K=0.0)
PERIODIC = ("x", "y")


def violent(seed: int, mesh: Mesh, gas=IDEAL) -> State:
    """Cold gas that moves every which way at Mach numbers of 10 to 1000; dense and thin cells side by side."""
    random = np.random.default_rng(seed)
    n = 10.0 ** random.uniform(-3.0, -0.02, mesh.cells)
    T = 10.0 ** random.uniform(-7.0, -3.0, mesh.cells)
    velocity = random.standard_normal((2, *mesh.cells))
    return State.of(gas, mesh, n, T, tuple(velocity))


def conserved_of(n, u, v, p):
    return np.array([n, n * u, n * v, p / IDEAL.compressibility(n) + 0.5 * n * (u * u + v * v)])


def flux_of(n, u, v, p):
    energy = conserved_of(n, u, v, p)[3]
    return np.array([n * u, n * u * u + p, n * u * v, (energy + p) * u])


def update_behind(flux, state, speed):
    """What a flux makes of the gas that its waves, of a speed towards it, have reached; the gas is on the right."""
    return conserved_of(*state) - (flux_of(*state) - flux) / speed


def test_the_state_behind_the_waves_of_the_positive_flux_is_admissible():
    random = np.random.default_rng(1)
    size = 20000
    n_l, n_r = 1.0 - 10.0 ** random.uniform(-6.0, -1e-3, (2, size))
    T_l, T_r = 10.0 ** random.uniform(-6.0, 2.0, (2, size))
    u_l, u_r, v_l, v_r = random.standard_normal((4, size)) * 10.0 ** random.uniform(-2.0, 2.0, size)
    left, right = ((n, u, v, IDEAL.pressure(n, T)) for n, u, v, T in ((n_l, u_l, v_l, T_l), (n_r, u_r, v_r, T_r)))
    s_r = u_r + IDEAL.sound_speed(n_r, T_r) + 0.5 * np.maximum(u_l - u_r, 0.0) / IDEAL.gap(n_r)
    reached = s_r > 1e-3 * np.abs(u_r)  # else the gas runs away from the face

    def share_of_admissible(flux):
        n, mx, my, e = update_behind(np.array(flux), right, s_r)[:, reached]
        heat = e - 0.5 * (mx * mx + my * my) / n
        return np.mean((n > 0.0) & (n < 1.0) & (heat > -1e-12 * e))

    fluxes = np.vectorize(lambda *states: POSITIVE.flux(IDEAL, *states))(*left, *right)
    others = np.vectorize(lambda *states: HLLC_LOW_MACH.flux(IDEAL, *states))(*left, *right)
    assert share_of_admissible(fluxes) == 1.0
    assert share_of_admissible(others) < 1.0


def test_the_positive_flux_is_that_of_the_gas_where_both_sides_are_alike():
    state = (0.3, -0.2, 0.7, 0.4)
    np.testing.assert_allclose(POSITIVE.flux(IDEAL, *state, *state), flux_of(*state), rtol=1e-14)


@pytest.mark.parametrize("periodic", [(True, True), (False, True), (False, False)])
@pytest.mark.parametrize("seed", range(3))
def test_a_step_that_second_order_cannot_do_is_done_and_books_close(seed, periodic):
    mesh = Mesh.rectangle((24, 150), aspect_ratio=6.0, periodic=periodic)  # two tiles in y
    state = violent(seed, mesh)
    before, integrator = state.copy(), Godunov(IDEAL, ElasticWall(), mesh)
    dt = 0.5 * integrator.largest_step(state)
    integrator.step(state, dt)
    assert integrator.counts()["first_order_cells"] > 0
    assert not inadmissible(state).any()
    assert state.mass == pytest.approx(before.mass, rel=1e-13)
    assert state.energy == pytest.approx(before.energy, rel=1e-13)
    for axis, wraps in enumerate(periodic):
        if wraps:
            momentum, size = state.conserved[1 + axis], np.abs(state.conserved[1 + axis])
            change = mesh.integral(momentum - before.conserved[1 + axis])
            assert abs(change) < 1e-13 * mesh.integral(size)


def test_cells_away_from_those_that_fall_back_keep_their_bits():
    """One violent spot in a quiet gas: the step is the second-order one but for the spot and what touches it."""
    mesh = Mesh.rectangle((32, 32), periodic=PERIODIC)
    state = State.of(IDEAL, mesh, 0.1 + 0.01 * np.sin(2.0 * np.pi * mesh.x)[:, None], 1.0, (0.1, 0.05))
    state.conserved[:, 14:18, 13:17] = violent(0, Mesh.rectangle((4, 4))).conserved
    integrator = Godunov(IDEAL, ElasticWall(), mesh)
    dt = integrator.largest_step(state)
    unguarded, before = np.empty_like(state.conserved), state.conserved.copy()
    integrator._flow(before, unguarded, dt)
    integrator.step(state, dt)
    changed = (state.conserved != unguarded).any(axis=0)
    assert inadmissible(State(IDEAL, mesh, unguarded)).any() and integrator.counts()["first_order_cells"] > 0
    assert not inadmissible(state).any()
    i, j = np.argwhere(changed).T
    assert changed.any() and np.abs(i - 15.5).max() <= 4.0 and np.abs(j - 14.5).max() <= 4.0


def least_ahead(state: State, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """The least density and pressure of the states at the faces of each cell, half a step ahead; square cells."""
    n, p, width = state.density, state.pressure, state.mesh.dx[0]
    stiffness, half = p * IDEAL.adiabatic_exponent(n), 0.5 * dt / width
    slopes_of = np.vectorize(VAN_LEER.limited)
    found = [n, p, 0.0, 0.0]
    for axis, velocity in enumerate(state.velocity):
        n_s, w_s, p_s = (slopes_of(q - np.roll(q, 1, axis), np.roll(q, -1, axis) - q) for q in (n, velocity, p))
        found[0] = found[0] - half * (velocity * n_s + n * w_s)
        found[1] = found[1] - half * (velocity * p_s + stiffness * w_s)
        found[2], found[3] = np.maximum(found[2], 0.5 * abs(n_s)), np.maximum(found[3], 0.5 * abs(p_s))
    return found[0] - found[2], found[1] - found[3]


def test_face_states_that_are_inadmissible_half_a_step_ahead_are_found():
    """Also where density and pressure are both negative: sound speed and fluxes of such a state are numbers."""
    mesh, found = Mesh.rectangle((16, 16), periodic=PERIODIC), 0
    for seed in range(20):
        state = violent(seed, mesh)
        integrator, after = Godunov(IDEAL, ElasticWall(), mesh), np.empty_like(state.conserved)
        dt = integrator.largest_step(state)
        integrator._flow(state.conserved, after, dt)
        density, pressure = least_ahead(state, dt)
        assert not np.isfinite(after[:, (density < 0.0) | (pressure < 0.0)]).any()
        found += int(((density < 0.0) & (pressure < 0.0)).sum())
    assert found > 5


def test_cells_are_spared_stresses_that_would_take_their_heat():
    gas = Grossman(L=0.0, K=5e-3)
    mesh = Mesh.rectangle((12, 12), periodic=PERIODIC)
    (stress,) = [Viscosity(1.0).stress(gas, Godunov(gas, ElasticWall(), mesh).boundary, mesh)]
    random = np.random.default_rng(0)
    state = State.of(gas, mesh, 0.2, 1.0, tuple(0.1 * random.standard_normal((2, *mesh.cells))))
    spared = np.array([[0, 0], [5, 7], [11, 3], [4, 11]])
    before, free = state.copy(), state.copy()
    stress.advance(free.conserved, 1e-2, np.empty((0, 2), int))
    stress.advance(state.conserved, 1e-2, spared)
    at = tuple(spared.T)
    np.testing.assert_array_equal(state.conserved[:, *at], before.conserved[:, *at])
    assert (free.conserved[1:, *at] != before.conserved[1:, *at]).all()
    for q in range(1, 4):
        change, size = state.conserved[q] - before.conserved[q], np.abs(before.conserved[q])
        assert abs(mesh.integral(change)) < 1e-13 * mesh.integral(size)


def test_a_step_whose_stresses_would_leave_a_cell_without_heat_is_done():
    """A cold cell between hot ones that shear it: explicit stresses of a whole step overdo it."""
    gas, mesh = Grossman(L=0.0, K=2e-2), Mesh.rectangle((16, 16), periodic=PERIODIC)
    found = 0
    for seed in range(20):
        random = np.random.default_rng(seed)
        T = 10.0 ** random.uniform(-6.0, 0.0, mesh.cells)
        state = State.of(gas, mesh, 0.2, T, tuple(0.5 * random.standard_normal((2, *mesh.cells))))
        integrator, energy = Godunov(gas, ElasticWall(), mesh, [Viscosity(1.0)]), state.energy
        try:
            integrator.step(state, 0.3 * integrator.largest_step(state))
        except StepRejected:
            continue
        found += integrator.counts()["unstressed_cells"] > 0
        assert state.energy == pytest.approx(energy, rel=1e-12) and not inadmissible(state).any()
    assert found > 5


def test_heat_below_the_round_off_of_the_flow_is_none():
    """Whether it is positive there depends on the order of the sums; no such state is saved as a good one."""
    mesh = Mesh.rectangle((4, 4), periodic=PERIODIC)
    for T, known in ((1e-16, False), (1e-12, True)):
        state = State.of(IDEAL, mesh, 0.1, T, (1.0, 0.0))
        assert inadmissible(state).all() != known
        assert (Godunov(IDEAL, ElasticWall(), mesh).largest_step(state) > 0.0) == known
