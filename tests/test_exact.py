"""The exact solutions, against the equations themselves and against formulas written independently."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from hydro.exact import (
    PrimitiveState,
    SimpleWave,
    acoustic_eigenmode,
    cell_averages,
    conduction_mode_decay,
    homogeneous_cooling,
    isobaric_profile,
    solve,
)
from hydro.exact.riemann import Isentrope
from hydro.gas import Grossman, HardDisks

IDEAL = Grossman(L=0.0, K=0.0)
GRANULAR = Grossman(L=5e4, K=2e-3)


class Henderson(HardDisks):
    """Henderson's disks, Z = (1 + eta^2/8)/(1 - eta)^2 with eta = CLOSE n: finite at n = 1."""

    CLOSE = math.pi / math.sqrt(12.0)

    def packing_density(self):
        return 1.0

    def compressibility(self, n):
        eta = self.CLOSE * n
        return (1.0 + eta * eta / 8.0) / (1.0 - eta) ** 2

    def compressibility_slope(self, n):
        eta = self.CLOSE * n
        return self.CLOSE * (0.25 * eta / (1.0 - eta) ** 2 + 2.0 * (1.0 + eta * eta / 8.0) / (1.0 - eta) ** 3)


CLOSURES = pytest.mark.parametrize("gas", [IDEAL, Henderson()], ids=["grossman", "henderson"])
PROBLEMS = {
    "sod": ((0.3, 0.0, 1.0), (0.03, 0.0, 0.1)),
    "collision": ((0.3, 5.0, 1.0), (0.03, -5.0, 0.1)),
    "parting": ((0.3, -1.0, 1.0), (0.1, 1.0, 0.4)),
    "strong shock into dense gas": ((0.3, 0.0, 1e4), (0.7, 0.0, 1e-3)),
    "gas against cluster": ((0.76, 0.1, 0.02), (0.004, -0.2, 0.01)),
    "near close packing": ((0.97, 0.0, 100.0), (1e-4, 0.3, 1e-6)),
    "weak": ((0.3, 0.2, 1.0), (0.3, 0.2, 1.0 + 1e-9)),
}
EACH_PROBLEM = pytest.mark.parametrize(
    ("left", "right"), [tuple(PrimitiveState(*s) for s in pair) for pair in PROBLEMS.values()], ids=list(PROBLEMS)
)


def fluxes(gas, state, speed):
    """Fluxes of mass, momentum and energy in the frame that moves with `speed`."""
    n, p, u = state.density, state.pressure, state.velocity - speed
    return np.array([n * u, n * u * u + p, u * (n * gas.temperature(n, p) + 0.5 * n * u * u + p)])


def entropy_like(n, p):
    """T (1-n)^2/n, constant on the isentropes of the Grossman closure."""
    return p * (1.0 - n) ** 3 / (n * n * (1.0 + n))


def grossman_escape_speed(n, T):
    """Integral of c dn/n in closed form: with s^2 = n/(1-n), T ~ s^2 (1+s^2) and du ~ (8 (1+3 s^2))^(1/2) ds."""
    y = np.sqrt(3.0 * n / (1.0 - n))
    return np.sqrt(T * (1.0 - n) ** 2 / n) * math.sqrt(2.0 / 3.0) * (y * np.sqrt(1.0 + y * y) + np.arcsinh(y))


@CLOSURES
@EACH_PROBLEM
def test_shocks_conserve_mass_momentum_energy(gas, left, right):
    solution = solve(gas, left, right)
    for wave in (solution.left, solution.right):
        if wave.kind == "shock":
            before, after = (fluxes(gas, state, wave.head) for state in (wave.ahead, wave.behind))
            np.testing.assert_allclose(after, before, rtol=1e-10)
            assert wave.behind.density > wave.ahead.density


@CLOSURES
@EACH_PROBLEM
def test_rarefactions_obey_the_equations_of_the_fan(gas, left, right):
    """In a fan du = -+c dn/n and dp = c^2 dn: integrated independently, by an ODE solver from the head to the star."""
    solution = solve(gas, left, right)
    for wave in (solution.left, solution.right):
        if wave.kind == "rarefaction" and wave.ahead.density - wave.behind.density > 1e-6:

            def slopes(log_n, y, wave=wave):
                n, p = math.exp(log_n), math.exp(y[1])
                exponent = gas.adiabatic_exponent(n)
                return [wave.side * math.sqrt(exponent * p / n), exponent]

            span = (math.log(wave.ahead.density), math.log(wave.behind.density))
            start = [wave.ahead.velocity, math.log(wave.ahead.pressure)]
            end = solve_ivp(slopes, span, start, method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
            np.testing.assert_allclose(end, [solution.velocity, math.log(solution.pressure)], rtol=1e-10, atol=1e-10)


@EACH_PROBLEM
def test_fans_keep_entropy_and_riemann_invariant(left, right):
    solution = solve(IDEAL, left, right)
    for wave in (solution.left, solution.right):
        if wave.kind == "rarefaction":
            xi = np.linspace(wave.head, wave.tail, 50)[1:-1]
            n, u, p = solution.sample(xi)
            T = IDEAL.temperature(n, p)
            invariant = wave.side * u - grossman_escape_speed(n, T)
            np.testing.assert_allclose(entropy_like(n, p), entropy_like(wave.ahead.density, wave.ahead.pressure), 1e-12)
            np.testing.assert_allclose(invariant, invariant[0], rtol=1e-12)
            np.testing.assert_allclose(u + wave.side * IDEAL.sound_speed(n, T), xi, rtol=1e-12, atol=1e-12)


@EACH_PROBLEM
def test_star_state_lies_between_ordered_waves(left, right):
    solution = solve(IDEAL, left, right)
    speeds = [solution.left.head, solution.left.tail, solution.velocity, solution.right.tail, solution.right.head]
    assert np.all(np.diff(speeds) >= -1e-15)
    n, u, p = solution.sample([speeds[0] - 1.0, solution.velocity - 1e-12, solution.velocity + 1e-12, speeds[-1] + 1.0])
    np.testing.assert_array_equal(n, [left.density, solution.left.behind.density, solution.right.behind.density,
                                      right.density])  # fmt: skip
    np.testing.assert_array_equal(u, [left.velocity, solution.velocity, solution.velocity, right.velocity])
    np.testing.assert_array_equal(p, [left.pressure, solution.pressure, solution.pressure, right.pressure])


@EACH_PROBLEM
def test_galilean_invariance(left, right):
    drift, xi = 3.7, np.linspace(-6.0, 6.0, 101)
    moving = solve(IDEAL, *(state._replace(velocity=state.velocity + drift) for state in (left, right)))
    n, u, p = solve(IDEAL, left, right).sample(xi)
    np.testing.assert_allclose(moving.sample(xi + drift), [n, u + drift, p], rtol=1e-11, atol=1e-11)


@EACH_PROBLEM
def test_mirror_symmetry(left, right):
    xi = np.linspace(-6.0, 6.0, 100)
    mirrored = solve(IDEAL, *(state._replace(velocity=-state.velocity) for state in (right, left)))
    n, u, p = solve(IDEAL, left, right).sample(xi)
    np.testing.assert_allclose(mirrored.sample(-xi), [n, -u, p], rtol=1e-13, atol=1e-14)


def test_equal_states_stay_and_a_contact_only_moves():
    contact = solve(IDEAL, PrimitiveState(0.76, 0.3, 0.02), PrimitiveState(0.004, 0.3, 0.02))
    assert contact.velocity == pytest.approx(0.3, abs=1e-15)
    assert contact.pressure == pytest.approx(0.02, rel=1e-14)
    n, _, _ = contact.sample([0.29, 0.31])
    np.testing.assert_allclose(n, [0.76, 0.004], rtol=1e-14)


def test_weak_shock_travels_at_the_mean_characteristic_speed():
    """To second order in the strength, and with no loss of digits as the strength goes to zero."""
    for strength in (1e-5, 1e-9, 1e-13):
        wave = solve(IDEAL, PrimitiveState(0.3, 0.0, 1.0 + strength), PrimitiveState(0.3, 0.0, 1.0)).right
        u_c = [s.velocity + IDEAL.sound_speed(s.density, IDEAL.temperature(s.density, s.pressure))
               for s in (wave.ahead, wave.behind)]  # fmt: skip
        assert wave.kind == "shock"
        assert wave.head == pytest.approx(sum(u_c) / 2.0, rel=strength**2 + 2e-15)


def toro_star(left, right, gamma=2.0):
    """Star pressure, velocity and densities of the ideal gas: Toro, Riemann Solvers, section 4.3."""

    def f(p, state):
        n, _, p0 = state
        if p > p0:
            A, B = 2.0 / ((gamma + 1.0) * n), (gamma - 1.0) / (gamma + 1.0) * p0
            return (p - p0) * math.sqrt(A / (p + B))
        a = math.sqrt(gamma * p0 / n)
        return 2.0 * a / (gamma - 1.0) * ((p / p0) ** ((gamma - 1.0) / (2.0 * gamma)) - 1.0)

    def density(p, state):
        n, _, p0 = state
        g = (gamma - 1.0) / (gamma + 1.0)
        return n * (p / p0 + g) / (g * p / p0 + 1.0) if p > p0 else n * (p / p0) ** (1.0 / gamma)

    p = brentq(lambda p: f(p, left) + f(p, right) + right[1] - left[1], 1e-14, 1e4, xtol=1e-300, rtol=1e-14)
    return p, 0.5 * (left[1] + right[1] + f(p, right) - f(p, left)), density(p, left), density(p, right)


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ((1.0, 0.0, 1.0), (0.125, 0.0, 0.1)),
        ((1.0, -1.0, 0.4), (1.0, 1.0, 0.4)),
        ((1.0, 0.0, 1000.0), (1.0, 0.0, 0.01)),
        ((6.0, 19.6, 460.9), (6.0, -6.2, 46.1)),
    ],
    ids=["sod", "parting", "blast", "collision"],
)
def test_dilute_limit_is_the_ideal_gas_of_exponent_two(left, right):
    """Scaled to densities of 1e-4 and 1e-6: the difference from Toro's formulas is of the order of n or less."""
    expected = np.array(toro_star(left, right))
    differences = []
    for dilution in (1e-4, 1e-6):
        solution = solve(IDEAL, *(PrimitiveState(dilution * n, u, dilution * p) for n, u, p in (left, right)))
        densities = (solution.left.behind.density, solution.right.behind.density)
        star = np.array([solution.pressure, solution.velocity * dilution, *densities]) / dilution
        differences.append(np.abs(star - expected) / np.abs(expected).max())
    assert np.all(differences[1] < 5e-5)
    assert np.all(differences[1] < 1.02e-2 * differences[0] + 1e-12)


def test_no_shock_reaches_close_packing():
    """Behind the strongest shock into n0 = 0.7 twice 1/(n Z) is 1/n0 - 1/n: T0 and p0 no longer matter."""
    solution = solve(IDEAL, PrimitiveState(0.7, 1e7, 1.0), PrimitiveState(0.7, -1e7, 1.0))
    limit = brentq(lambda n: 2.0 * (1.0 - n) / (n * (1.0 + n)) - 1.0 / 0.7 + 1.0 / n, 0.7, 1.0, xtol=1e-15)
    assert solution.right.behind.density == pytest.approx(limit, rel=1e-10)


def test_a_closure_finite_at_close_packing_says_when_there_is_no_shock():
    with pytest.raises(ValueError, match="below n = 1"):
        solve(Henderson(), PrimitiveState(0.99, 1e4, 1.0), PrimitiveState(0.99, -1e4, 1.0))


def test_near_vacuum_and_vacuum():
    n, T = 0.3, 2.0
    p, escape = float(IDEAL.pressure(n, T)), float(grossman_escape_speed(n, T))
    parting = [PrimitiveState(n, side * escape * (1.0 - 1e-4), p) for side in (-1, 1)]
    solution = solve(IDEAL, *parting)
    star = solution.left.behind.density
    assert solution.velocity == pytest.approx(0.0, abs=1e-14)
    assert grossman_escape_speed(star, IDEAL.temperature(star, solution.pressure)) == pytest.approx(
        1e-4 * escape, 1e-10
    )
    with pytest.raises(ValueError, match="vacuum opens"):
        solve(IDEAL, *(state._replace(velocity=1.001 * state.velocity) for state in parting))


@pytest.mark.parametrize("state", [(0.0, 0.0, 1.0), (1.0, 0.0, 1.0), (0.5, 0.0, 0.0), (0.5, math.nan, 1.0)])
def test_states_outside_the_gas_are_refused(state):
    with pytest.raises(ValueError, match="not a state"):
        solve(IDEAL, PrimitiveState(*state), PrimitiveState(0.5, 0.0, 1.0))


@pytest.mark.parametrize("n0", [1e-6, 0.1, 0.7, 0.99, 1.0 - 1e-6])
def test_isentrope_against_closed_forms(n0):
    isentrope, n = Isentrope(IDEAL, n0, IDEAL.pressure(n0, 1.3)), n0 * np.logspace(-12, 0, 60)
    T = 1.3 * (n / (1.0 - n) ** 2) / (n0 / (1.0 - n0) ** 2)
    rounding = 1e-14 + 1e-16 / (1.0 - n0)
    np.testing.assert_allclose(isentrope.temperature(n), T, rtol=rounding)
    np.testing.assert_allclose(isentrope.escape_speed(n) / grossman_escape_speed(n0, 1.3),
                               grossman_escape_speed(n, T) / grossman_escape_speed(n0, 1.3), atol=rounding)  # fmt: skip


@CLOSURES
def test_simple_wave_satisfies_the_equations(gas):
    """Central differences of the exact solution: the residual of the three conservation laws falls as h^2."""
    wave = SimpleWave(gas, n0=0.4, T0=1.0, amplitude=0.2)
    t, x = 0.5 * wave.breaking_time, np.linspace(0.0, 1.0, 41)

    def flux(x):
        n, u, p = wave.primitive(x, t)
        return fluxes(gas, PrimitiveState(n, u, p), 0.0)

    def residual(h):
        rate = wave.conserved(x, t + h * wave.breaking_time) - wave.conserved(x, t - h * wave.breaking_time)
        return np.abs(rate / (2.0 * h * wave.breaking_time) + (flux(x + h) - flux(x - h)) / (2.0 * h)).max()

    assert residual(1e-3) / residual(5e-4) == pytest.approx(4.0, rel=0.01)
    assert residual(1e-4) < 1e-4 * np.abs(wave.conserved(x, t)).max() / wave.breaking_time


def test_simple_wave_starts_as_told_conserves_mass_and_breaks():
    wave = SimpleWave(IDEAL, n0=0.4, T0=1.5, amplitude=0.3, length=2.0)
    x, faces = np.linspace(0.0, 2.0, 33), np.linspace(0.0, 2.0, 65)
    n, u, p = wave.primitive(x, 0.0)
    np.testing.assert_allclose(n, 0.4 * (1.0 + 0.3 * np.sin(np.pi * x)), rtol=1e-14)
    np.testing.assert_allclose(entropy_like(n, p), entropy_like(0.4, IDEAL.pressure(0.4, 1.5)), rtol=1e-13)
    assert u[0] == pytest.approx(0.0, abs=1e-14)
    early, late = (cell_averages(lambda x, t=t: wave.conserved(x, t), faces) for t in (0.0, 0.6 * wave.breaking_time))
    np.testing.assert_allclose(late.mean(axis=1), early.mean(axis=1), rtol=1e-11)
    with pytest.raises(ValueError, match="smooth"):
        wave.primitive(x, 1.001 * wave.breaking_time)
    with pytest.raises(ValueError, match="inside"):
        SimpleWave(IDEAL, n0=0.8, T0=1.0, amplitude=0.3)


def test_acoustic_eigenmode_is_an_eigenvector_and_the_limit_of_the_simple_wave():
    n, T, amplitude = 0.4, 1.7, 1e-6
    mode = acoustic_eigenmode(IDEAL, n, T, wavenumber=3.0)
    vector = np.array([mode.density, mode.velocity, mode.pressure])
    p = IDEAL.pressure(n, T)
    jacobian = np.array([[0.0, n, 0.0], [0.0, 0.0, 1.0 / n], [0.0, IDEAL.adiabatic_exponent(n) * p, 0.0]])
    np.testing.assert_allclose(jacobian @ vector, mode.speed * vector, rtol=1e-14)
    assert mode.frequency == 3.0 * mode.speed
    x, t = np.linspace(0.0, 1.0, 17), 0.3
    wave = np.array(SimpleWave(IDEAL, n, T, amplitude).primitive(x, t))
    linear = np.array([n, 0.0, p])[:, None] + amplitude * vector[:, None] * np.sin(2.0 * np.pi * (x - mode.speed * t))
    np.testing.assert_allclose(wave, linear, atol=100.0 * amplitude**2)


def test_homogeneous_cooling_solves_its_equation():
    n, T0, times = 0.3, 1.4, np.linspace(0.0, 50.0, 6)
    exact = homogeneous_cooling(GRANULAR, n, T0, times)
    rate = solve_ivp(lambda t, T: -GRANULAR.cooling(n, T) / n, (0.0, 50.0), [T0], t_eval=times, rtol=1e-11, atol=1e-14)
    np.testing.assert_allclose(exact, rate.y[0], rtol=1e-9)
    assert exact[-1] < 0.5 * T0
    assert homogeneous_cooling(IDEAL, n, T0, 50.0) == T0


def test_conduction_mode_decay_is_the_rate_of_the_heat_equation():
    n, T0, k, amplitude = 0.2, 1.3, 2.0 * np.pi, 1e-6
    x = np.arange(32) / 32.0
    T = T0 + amplitude * np.cos(k * x)

    def ddx(f):
        return np.fft.irfft(2j * np.pi * np.arange(17) * np.fft.rfft(f), 32)

    rate = ddx(GRANULAR.conductivity(n, T) * ddx(T)) / n
    expected = -conduction_mode_decay(GRANULAR, n, T0, k) * (T - T0)
    np.testing.assert_allclose(rate, expected, atol=1e-5 * np.abs(expected).max())


def test_cell_averages_of_polynomials_and_of_several_functions():
    faces = np.array([0.0, 0.1, 0.5, 1.3])
    averages = cell_averages(lambda x: (x**15, np.ones_like(x)), faces)
    assert averages.shape == (2, 3)
    np.testing.assert_allclose(averages, [np.diff(faces**16) / 16.0 / np.diff(faces), np.ones(3)], rtol=1e-13)


def test_isobaric_profile():
    smooth, jump = isobaric_profile(0.004, 0.76, 0.05, length=2.0), isobaric_profile(0.004, 0.76, 0.0, length=2.0)
    np.testing.assert_allclose(smooth([0.0, 0.5, 1.0, 2.0]), [0.004, 0.382, 0.76, 0.004], rtol=1e-12)
    np.testing.assert_allclose(smooth(0.5 + 0.025) - smooth(0.5 - 0.025), 0.756 * np.tanh(1.0), rtol=1e-3)
    averages = cell_averages(jump, np.linspace(0.0, 2.0, 9))
    np.testing.assert_allclose(averages, [0.004, 0.004, 0.76, 0.76, 0.76, 0.76, 0.004, 0.004], rtol=1e-14)
