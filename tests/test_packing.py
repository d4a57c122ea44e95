"""No solver knows at which density a gas packs: the paper's gas in other units of density gives the same physics."""

from __future__ import annotations

import math

import numpy as np
import pytest
from closures import PACKED, Dilute, Rescaled

from hydro.errors import RunFailed
from hydro.exact import PrimitiveState, SimpleWave, solve
from hydro.gas import Grossman
from hydro.gas.packing import density_at, gap_at, log_void
from hydro.initial.checkpoint import refilled
from hydro.mesh import Mesh
from hydro.observables.clustering import extremes
from hydro.state import State, inadmissible, worst_cell
from hydro.steady.balance import Balance
from hydro.steady.bifurcation import ExtendedBranch
from hydro.steady.continuation import Family, follow
from hydro.steady.extended import extended_state
from hydro.steady.growth import growth_of, growth_rate
from hydro.steady.localized import steady_state
from hydro.steady.marginal import critical_aspect_ratio, tongue
from hydro.steady.nearest import candidates, nearest
from hydro.walls import ThermalWall, VibratingWall

PAPER, OTHER = Grossman(L=5e4, K=2e-3), Rescaled(L=5e4, K=2e-3)
F = 0.0235
SAME = {"rel": 1e-10}
WALLS = pytest.mark.parametrize(
    "wall", [VibratingWall(strength=0.228), ThermalWall(1.3)], ids=["vibrating", "thermal"]
)  # fmt: skip


@pytest.mark.parametrize("gas", [PAPER, OTHER, Dilute(5e4, 2e-3)], ids=["grossman", "rescaled", "dilute"])
def test_w_and_the_density_are_each_others_inverse(gas):
    w = np.array([-2.0, 0.0, 0.5, 30.0])
    n = density_at(gas, w)
    assert n == pytest.approx(1.0 / (1.0 / gas.packing_density() + np.exp(w)), rel=1e-14)
    assert log_void(gas, n) == pytest.approx(w, abs=1e-14)
    assert gap_at(gas, w) == pytest.approx(gas.gap(n), rel=1e-13)
    assert gap_at(gas, w) == pytest.approx(np.exp(w) * n, rel=1e-14)


def test_a_gap_below_the_last_digit_of_the_density_is_there():
    assert gap_at(OTHER, -800.0 + math.log(1.0 / PACKED)) == pytest.approx(0.0, abs=1e-300)
    assert gap_at(OTHER, -100.0) == pytest.approx(PACKED * math.exp(-100.0), rel=1e-14)


def test_the_rescaled_gas_is_the_papers():
    n, T = np.array([1e-3, 0.3, 0.9, 0.999]), 0.7
    for name in ("pressure", "conductivity", "cooling"):
        assert getattr(OTHER, name)(PACKED * n, T) == pytest.approx(PACKED * getattr(PAPER, name)(n, T), rel=1e-12)
    for mine, its in zip(OTHER.viscosities(PACKED * n, T), PAPER.viscosities(n, T), strict=True):
        assert mine == pytest.approx(PACKED * its, rel=1e-12)
    for name in ("pressure_slopes", "conductivity_slopes", "cooling_slopes"):
        for mine, its, factor in zip(
            getattr(OTHER, name)(PACKED * n, T), getattr(PAPER, name)(n, T), (1.0, PACKED), strict=True
        ):
            assert mine == pytest.approx(factor * its, rel=1e-11)
    assert OTHER.sound_speed(PACKED * n, T) == pytest.approx(PAPER.sound_speed(n, T), rel=1e-12)
    assert OTHER.density(PACKED, T) == pytest.approx(PACKED * PAPER.density(1.0, T), rel=1e-14)


@WALLS
@pytest.mark.parametrize("wave", [0, 1])
def test_steady_states_and_their_growth_rates(wall, wave):
    mesh = Mesh.rectangle((16, 16))
    paper, other = (steady_state(gas, wall, mesh, f, wave) for gas, f in ((PAPER, F), (OTHER, PACKED * F)))
    assert other.state.density == pytest.approx(PACKED * paper.state.density, **SAME)
    assert other.state.temperature == pytest.approx(paper.state.temperature, **SAME)
    growths = [growth_of(found, 200.0) for found in (paper, other)]
    assert growth_rate(growths[1]) == pytest.approx(growth_rate(growths[0]), **SAME)
    every = [[mode.growth_rate for growth in found for mode in growth.modes] for found in growths]
    assert every[1] == pytest.approx(every[0], rel=1e-8)  # those far from zero are not found to more digits


def points(gas, parameter, limits, f):
    family = Family(Balance.of(gas, VibratingWall(strength=0.228), Mesh.rectangle((16, 16)), f), parameter)
    (start,) = ExtendedBranch(family).bifurcations(np.geomspace(*limits, 6))
    found = [point for _, point in zip(range(4), follow(family, start, limits, 0.2), strict=False)]
    return np.array([(point.value, family.amplitude(point.vector)) for point in [start, *found]])


def test_branches_in_the_area_fraction():
    paper, other = points(PAPER, "f", (0.026, 0.031), 1.0), points(OTHER, "f", (PACKED * 0.026, PACKED * 0.031), 1.0)
    assert other[:, 0] == pytest.approx(PACKED * paper[:, 0], **SAME)
    assert other[1:, 1] == pytest.approx(paper[1:, 1], rel=1e-9)


def test_branches_in_a_parameter_of_the_closure():
    paper, other = points(PAPER, "L", (3e4, 9e4), 0.027), points(OTHER, "L", (3e4, 9e4), PACKED * 0.027)
    assert other[:, 0] == pytest.approx(paper[:, 0], **SAME)


@pytest.mark.parametrize("f", [1e-3, F, 0.6])
def test_extended_states_and_their_marginal_stability(f):
    paper, other = extended_state(PAPER, f), extended_state(OTHER, PACKED * f)
    x = np.linspace(0.0, 1.0, 11)
    assert other.log_void_at(x) + math.log(PACKED) == pytest.approx(paper.log_void_at(x), rel=1e-10, abs=1e-10)
    assert other.density_at(x) == pytest.approx(PACKED * paper.density_at(x), **SAME)
    for wall, name in ((VibratingWall(strength=0.228), "vibrating"), (ThermalWall(1.3), "thermal")):
        assert other.pressure(wall) == pytest.approx(PACKED * paper.pressure(wall), **SAME)
        assert other.temperature_at(x, wall) == pytest.approx(paper.temperature_at(x, wall), **SAME)
        ratios = [critical_aspect_ratio(state, name).aspect_ratio for state in (paper, other)]
        assert ratios[0] == ratios[1] or ratios[1] == pytest.approx(ratios[0], **SAME)


def test_tongues():
    paper, other = (tongue(gas, "vibrating", scan=14) for gas in (PAPER, OTHER))
    assert (other.f1, other.f2) == pytest.approx((PACKED * paper.f1, PACKED * paper.f2), **SAME)
    assert other.f_min == pytest.approx(PACKED * paper.f_min, rel=1e-8)
    assert other.aspect_ratio_min == pytest.approx(paper.aspect_ratio_min, **SAME)


def test_the_steady_state_nearest_to_a_state():
    wall, mesh = VibratingWall(strength=0.228), Mesh.rectangle((16, 16))
    state = steady_state(OTHER, wall, mesh, PACKED * F, 1).state
    assert candidates(state)[1] == 1
    found, _ = nearest(Balance.of(OTHER, wall, mesh, PACKED * F), state, candidates(state))
    assert found.wave == 1 and found.state.density == pytest.approx(state.density, rel=1e-8)


def test_densities_up_to_that_of_packing_are_admissible():
    mesh = Mesh.rectangle((2, 2))
    dense = State.of(OTHER, mesh, [[1.05, 0.1], [0.1, 1.2]], 1.0)
    assert inadmissible(dense).tolist() == [[False, False], [False, True]]
    assert worst_cell(dense).startswith("1 cells would leave 0 < n < 1.1, T > 0; cell (1, 1)")
    assert not inadmissible(State.of(Dilute(1.0, 1.0), mesh, 5.0, 1.0)).any()
    assert "would leave 0 < n, T > 0" in worst_cell(State.of(Dilute(1.0, 1.0), mesh, -5.0, 1.0))
    assert "would leave 0 < n < 1, T > 0" in worst_cell(State.of(PAPER, mesh, 5.0, 1.0))


def test_a_wall_may_be_as_dense_as_the_gas_packs():
    mesh = Mesh.rectangle((4, 4))
    paper, other = (
        State.of(gas, mesh, f * np.array([0.97, 0.9, 0.5, 0.1])[:, None], 1.0)
        for gas, f in ((PAPER, 1.0), (OTHER, PACKED))
    )
    assert extremes(other) == pytest.approx(tuple(PACKED * n for n in extremes(paper)), rel=1e-14)
    assert extremes(paper)[1] > 0.97


def test_a_box_is_refilled_below_packing():
    mesh = Mesh.rectangle((4, 4))
    profile = np.linspace(0.2, 0.95, 4)[:, None]
    paper, other = State.of(PAPER, mesh, profile, 1.0), State.of(OTHER, mesh, PACKED * profile, 1.0)
    assert refilled(other, PACKED * 0.8).density == pytest.approx(PACKED * refilled(paper, 0.8).density, rel=1e-12)
    dilute = State.of(Dilute(1.0, 1.0), mesh, profile, 1.0)
    assert refilled(dilute, 0.8).density == pytest.approx(profile * 0.8 / profile.mean() * np.ones(4), rel=1e-12)


def test_riemann_problems_and_simple_waves():
    left, right = PrimitiveState(0.4, 0.0, 1.0), PrimitiveState(0.1, 0.0, 0.1)
    xi = np.linspace(-2.0, 2.0, 41)
    paper = solve(PAPER, left, right).sample(xi)
    other = solve(OTHER, *(PrimitiveState(PACKED * n, u, PACKED * p) for n, u, p in (left, right))).sample(xi)
    assert other.density == pytest.approx(PACKED * paper.density, **SAME)
    assert other.velocity == pytest.approx(paper.velocity, rel=1e-10, abs=1e-12)
    with pytest.raises(ValueError, match=r"not a state with 0 < n < 1\.1 and"):
        solve(OTHER, PrimitiveState(1.2, 0.0, 1.0), right)
    with pytest.raises(ValueError, match=r"densities from 0\.5\S* to 1\.5 are not inside 0 < n < 1\.1"):
        SimpleWave(OTHER, 1.0, 1.0, 0.5)


def test_the_riemann_problem_of_a_gas_that_never_packs_is_the_dilute_limit():
    left, right, xi = PrimitiveState(0.4, 0.0, 1.0), PrimitiveState(0.1, 0.0, 0.1), np.linspace(-2.0, 2.0, 41)
    dilute = solve(Dilute(0.0, 0.0), left, right)
    thin = solve(PAPER, *(PrimitiveState(1e-9 * n, u, 1e-9 * p) for n, u, p in (left, right)))
    assert dilute.left.kind == "rarefaction" and dilute.right.kind == "shock"
    assert dilute.sample(xi).density == pytest.approx(1e9 * thin.sample(xi).density, rel=1e-7)
    assert dilute.sample(xi).velocity == pytest.approx(thin.sample(xi).velocity, rel=1e-7, abs=1e-9)


@WALLS
def test_a_gas_that_never_packs_has_steady_states(wall):
    gas, mesh = Dilute(L=2e4, K=2e-3), Mesh.rectangle((128, 1))
    exact = extended_state(gas, 0.02)
    steady = steady_state(gas, wall, mesh, 0.02, 0)
    assert steady.state.density[:, 0] == pytest.approx(exact.density_at(mesh.x), rel=2e-3)
    with pytest.raises(RunFailed, match=r"the tongue at L = 20000, .* reaches beyond 1e-05 < f < 0\.98"):
        tongue(gas, "thermal", scan=14)


def test_slopes_of_the_balance_of_a_gas_that_never_packs():
    balance = Balance.of(Dilute(5e4, 2e-3), ThermalWall(1.3), Mesh.rectangle((3, 2)), 0.05)
    u = np.append(np.linspace(0.5, 3.0, 6), -3.0)
    matrix, in_log_p, mass, _ = balance.slopes(u)
    whole = np.block([[matrix.toarray(), in_log_p], [mass, 0.0]])
    by_difference = [(balance.residual(u + h) - balance.residual(u - h)) / 2e-5 for h in 1e-5 * np.eye(7)]
    np.testing.assert_allclose(np.transpose(by_difference), whole, rtol=1e-6, atol=1e-8)


def test_no_extended_state_beyond_packing():
    with pytest.raises(RunFailed, match=r"no extended state for L = 50000, f = 1\.2: it needs .* in 0 < n < 1\.1"):
        extended_state(OTHER, 1.2)
