"""Steady states, growth rates and branches: their parts, and their decks by the command line."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from conftest import summary_of
from scipy.sparse.linalg import ArpackNoConvergence

from hydro.choices import INTEGRATORS
from hydro.cli import main
from hydro.deck.evolution import FlowingGas, Time, Timeline
from hydro.deck.grains import GrainsGas
from hydro.deck.sections import Box, ClosedBox, Gas, ViscousGas
from hydro.deck.steady import BranchGas, SteadyGas
from hydro.errors import RunFailed
from hydro.gas import Grossman
from hydro.mesh import Faces, Geometry, Mesh
from hydro.output.checkpoint import read_checkpoint
from hydro.pictures.branches import stretches
from hydro.state import State
from hydro.steady.balance import Balance
from hydro.steady.bifurcation import ExtendedBranch
from hydro.steady.continuation import Family, between, follow
from hydro.steady.growth import Damping, first_column, growth_of, linearized, lower_half, with_mode
from hydro.steady.linear import Bordered
from hydro.steady.localized import chain, interpolated, ladder, steady_state, unit_cell
from hydro.steady.operators import Faces as Differences
from hydro.steady.spectrum import Linearization, even, odd, wave_sector
from hydro.steady.staggered import Between, Staggered
from hydro.steady.viscous import ViscousLinearization
from hydro.terms.viscosity.stress import Viscous, find_viscosities, stress_force
from hydro.verification.viscosity import rate_of
from hydro.walls import ThermalWall, VibratingWall

GAS = Grossman(L=5e4, K=2e-3)
WALLS = pytest.mark.parametrize("wall", [VibratingWall(strength=0.228), ThermalWall(1.3)], ids=["vibrating", "thermal"])

STEADY = """
kind = "steady"
gas  = { L = 5e4, f = 0.0235 }
box  = { aspect_ratio = 1.0 }
mesh = { cells = [16, 16] }
wall = { kind = "vibrating" }
steady = { wave = 1 }
"""
BRANCH = """
kind = "branch"
gas  = { L = 5e4 }
box  = { aspect_ratio = 1.0 }
mesh = { cells = [16, 16] }
branch = { parameter = "f", wave = 1, start = 0.0265, stop = 0.031, samples = 5 }
"""


@pytest.fixture
def run_text(tmp_path, capsys):
    """Runs a deck given as text: (folder, exit code, what went to stderr)."""

    def run(text: str, *overrides: str, name: str = "run"):
        deck = tmp_path / f"{name}.toml"
        deck.write_text(text)
        folder = tmp_path / name
        code = main([str(deck), *overrides, "--output", str(folder), "--quiet"])
        return folder, code, capsys.readouterr().err

    return run


@WALLS
def test_slopes_of_the_balance(wall):
    mesh = Mesh.rectangle((5, 4), 1.3, 2.0)
    balance = Balance.of(GAS, wall, mesh, 0.05)
    u = np.append(np.random.default_rng(0).uniform(-1.0, 3.0, 20), -3.0)
    matrix, in_log_p, mass, _ = balance.slopes(u)
    by_difference = np.empty((21, 21))
    for k, change in enumerate(1e-5 * np.eye(21)):
        by_difference[:, k] = (balance.residual(u + change) - balance.residual(u - change)) / 2e-5
    assert by_difference[:-1, :-1] == pytest.approx(matrix.toarray(), rel=1e-7, abs=1e-8)
    assert by_difference[:-1, -1] == pytest.approx(in_log_p[:, 0], rel=1e-7, abs=1e-8)
    assert by_difference[-1, :-1] == pytest.approx(mass[0], rel=1e-7)


@WALLS
def test_slopes_of_the_linearized_heat(wall):
    """Heating as a function of (n, T) of every cell: that of the balance, at any pressure, has the same slopes."""
    mesh = Mesh.rectangle((4, 3), 1.0)
    state = steady_state(GAS, wall, mesh, 0.05, 0).state
    linear = Linearization(state, wall, 200.0, even(mesh))
    w, p = np.log(1.0 / state.density - 1.0).ravel(), float(state.pressure.mean())
    balance = Balance.of(GAS, wall, mesh, 0.05)
    matrix, in_log_p, *_ = balance.slopes(np.append(w, math.log(p)))
    p_n, p_T = GAS.pressure_slopes(linear.n, linear.T)
    n_w = -linear.n * (1.0 - linear.n)
    at_pressure = linear.heat_T.toarray() @ np.diag(-p_n / p_T * n_w)  # w changes at fixed p
    assert at_pressure / p**1.5 == pytest.approx(matrix.toarray(), rel=1e-8, abs=1e-9)
    uniform = (linear.heat_p.toarray() + linear.heat_T.toarray() @ np.diag(linear.T / p)).sum(axis=1)  # p at fixed n
    assert uniform / p**0.5 == pytest.approx(in_log_p[:, 0], rel=1e-6, abs=1e-9)


def test_bordered_systems_where_the_inner_matrix_is_nearly_singular():
    from scipy import sparse

    rng = np.random.default_rng(3)
    inner = np.diag([2.0, 3.0, 1e-14]) + np.diag([0.5, 0.0], 1) + np.diag([0.5, 0.0], -1)
    column, row = rng.normal(size=(3, 1)), rng.normal(size=(1, 3))
    whole = np.block([[inner, column], [row, np.zeros((1, 1))]])
    wanted = rng.normal(size=4)
    solution = Bordered(sparse.csc_array(inner), column, row, np.zeros((1, 1))).solve(whole @ wanted)
    assert solution == pytest.approx(wanted, rel=1e-9)


def test_diffusion_is_second_order_and_conserves():
    errors = []
    for cells in (16, 32):
        mesh = Mesh.rectangle((cells, cells), 1.0, 3.0)
        x, y = mesh.x[:, None], mesh.y[None, :]
        field = np.cos(np.pi * x) * np.cos(np.pi * y)
        found = Differences(mesh).diffused(np.ones(cells**2), field.ravel()).reshape(mesh.cells)
        assert abs(found.sum()) < 1e-12
        errors.append(np.sqrt(np.mean((found / mesh.areas + 2.0 * np.pi**2 * field)[1:-1] ** 2)))
    assert errors[0] / errors[1] > 3.0


def test_a_wave_in_y_decays_as_on_the_whole_mesh():
    """The leak of a wave sector is that of the cosine on the mesh with all its cells."""
    mesh = Mesh.rectangle((6, 8), 1.7)
    line = unit_cell(mesh, 0)
    coefficient, profile = np.linspace(1.0, 2.0, 6), np.linspace(0.3, 1.0, 6) ** 2
    wave = np.cos(np.pi * 3 * (np.arange(8) + 0.5) / 8)
    full = Differences(mesh).diffused(np.repeat(coefficient, 8), np.outer(profile, wave).ravel()).reshape(6, 8)
    reduced = Differences(line).diffused(coefficient, profile)
    reduced = reduced - (wave_sector(line, 8, 1.7, 3).leak.ravel() * coefficient * profile)
    assert full == pytest.approx(np.outer(reduced, wave) / 8.0, abs=1e-12)


def test_chains_are_mirror_images():
    mesh = Mesh.rectangle((3, 8), 2.0)
    cell = unit_cell(mesh, 2)
    w = np.arange(12.0).reshape(3, 4)
    whole = chain(np.append(w, 7.0), cell, mesh, False)
    assert whole[-1] == 7.0
    assert np.array_equal(whole[:-1].reshape(3, 8), np.hstack([w, w[:, ::-1]]))
    shifted = chain(np.append(w, 7.0), cell, mesh, True)[:-1].reshape(3, 8)
    assert np.array_equal(shifted, np.hstack([w[:, ::-1], w]))


@pytest.mark.parametrize("cells", [(64, 64), (50, 37), (16, 200), (8, 8)])
def test_ladders_of_meshes_end_at_the_mesh(cells):
    mesh = Mesh.rectangle(cells, 1.5, 2.0)
    meshes = ladder(mesh)
    assert meshes[-1] is mesh
    assert all(rung.x_faces[-1] == pytest.approx(1.0) and rung.aspect_ratio == pytest.approx(1.5) for rung in meshes)
    assert max(meshes[0].cells) < 32 or meshes[0] is mesh


def test_interpolation_between_meshes_keeps_straight_lines():
    coarse, fine = Mesh.rectangle((8, 8)), Mesh.rectangle((16, 12))
    plane = (coarse.x[:, None] + 2.0 * coarse.y[None, :]).ravel()
    found = interpolated(np.append(plane, 3.0), coarse, fine)[:-1].reshape(16, 12)
    assert found[1:-1, 1:-1] == pytest.approx((fine.x[:, None] + 2.0 * fine.y[None, :])[1:-1, 1:-1])


def test_gradients_between_cells():
    mesh = Mesh.rectangle((40, 30), 1.0, 2.0)
    field = np.cos(np.pi * mesh.x)[:, None] * np.cos(2.0 * np.pi * mesh.y)[None, :]
    grid = Staggered(Between.cells(mesh.dx), Between.cells(mesh.dy))
    in_x, in_y = (
        (back @ (slope @ field.ravel())).reshape(mesh.cells) for back, slope in zip(grid.back, grid.slope, strict=True)
    )
    assert in_x == pytest.approx(-np.pi * np.outer(np.sin(np.pi * mesh.x), np.cos(2 * np.pi * mesh.y)), abs=0.03)
    assert in_y == pytest.approx(-2 * np.pi * np.outer(np.cos(np.pi * mesh.x), np.sin(2 * np.pi * mesh.y)), abs=0.05)


def test_the_two_halves_of_a_full_wave_have_the_modes_of_the_whole():
    """The union of the symmetric and antisymmetric modes on half of the box is the spectrum of all of it."""
    steady = steady_state(GAS, VibratingWall(strength=0.228), Mesh.rectangle((16, 32), 2.0), 0.0235, 2)
    halves = sorted(mode.growth_rate.real for growth in growth_of(steady, 200.0) for mode in growth.modes)[-3:]
    whole = Linearization(steady.state, VibratingWall(strength=0.228), 200.0, even(steady.balance.mesh)).leading()
    assert halves[::-1] == pytest.approx([mode.growth_rate.real for mode in whole[:3]], rel=1e-6)


VIBRATING = VibratingWall(strength=0.228)


def linear_cases():
    """(name, state, sector) on small meshes: waves of the extended state, one cluster, half of two clusters."""
    extended = steady_state(GAS, VIBRATING, Mesh.rectangle((32, 32), 2.0), 0.0235, 0)
    line = first_column(extended.state)
    for wave in (0, 1, 5):
        yield f"extended, {wave}", line, wave_sector(line.mesh, 32, 2.0, wave)
    one = steady_state(GAS, VIBRATING, Mesh.rectangle((14, 12)), 0.0235, 1).state
    yield "one cluster", one, even(one.mesh)
    two = lower_half(steady_state(GAS, VIBRATING, Mesh.rectangle((14, 24), 2.0), 0.0235, 2).state)
    yield "two clusters, odd", two, odd(two.mesh)


CASES = {name: (state, sector) for name, state, sector in linear_cases()}


def dense_rates(linear) -> np.ndarray:
    """All eigenvalues, of pairs those of positive frequency, but for the zero of mass and a constant potential."""
    values = np.linalg.eigvals(linear.matrix.toarray())
    if not linear.sector.leak.any():
        values = np.delete(values, np.argmin(np.abs(values)))
        if isinstance(linear, Linearization):
            values = np.delete(values, np.argmin(np.abs(values + linear.friction)))
    values = values[values.imag > -1e-9]
    return values[np.argsort(-values.real)]


@pytest.mark.parametrize("viscosity", [0.0, 1.0])
@pytest.mark.parametrize("name", CASES)
def test_no_mode_of_largest_growth_rate_is_missed(name, viscosity):
    """Sound among them, which lies far from the axis: against all eigenvalues, by dense algebra."""
    linear = linearized(CASES[name][0], VIBRATING, Damping(200.0, viscosity), CASES[name][1])
    every = dense_rates(linear)
    for count in (1, 3, 7, 16):
        found = [mode.growth_rate for mode in linear.leading(count)]
        assert [rate.real for rate in found] == pytest.approx(every.real[:count], rel=1e-7, abs=1e-9)
        assert all(np.min(np.abs(every - rate)) < 1e-7 for rate in found)


def test_oscillations_found_on_a_coarse_mesh_are_those_of_the_fine_one():
    steady = steady_state(GAS, VIBRATING, Mesh.rectangle((40, 40), 1.0), 0.0235, 1)
    (found,) = growth_of(steady, 200.0, 12)
    wanted = Linearization(steady.state, VIBRATING, 200.0, even(steady.balance.mesh)).leading(12)
    rates = [mode.growth_rate for mode in wanted]
    assert [mode.growth_rate for mode in found.modes] == pytest.approx(rates, rel=1e-6)
    assert any(rate.imag > 1.0 for rate in rates)


@pytest.mark.parametrize("name", CASES)
def test_without_viscosity_only_shear_is_added_to_the_modes(name):
    """As the factor of viscosity goes to zero: the modes of the potential, and as many that decay like friction."""
    state, sector = CASES[name]
    plain = dense_rates(Linearization(state, VIBRATING, 200.0, sector))
    viscous = dense_rates(ViscousLinearization(state, VIBRATING, 200.0, sector, 0.0))
    others = viscous[np.abs(viscous + 1.0 / 200.0) > 1e-6]
    plain = plain[np.abs(plain + 1.0 / 200.0) > 1e-6]
    assert np.sort_complex(others) == pytest.approx(np.sort_complex(plain), rel=1e-8, abs=1e-8)


def test_the_linearized_stress_is_that_of_the_integrators():
    """Force on every face for random velocities of the faces."""
    mesh = Mesh.rectangle((5, 4), 1.3, 2.0)
    rng = np.random.default_rng(2)
    state = State.of(GAS, mesh, rng.uniform(0.05, 0.5, mesh.cells), rng.uniform(0.5, 1.5, mesh.cells))
    linear = ViscousLinearization(state, VIBRATING, 200.0, even(mesh), 0.7)
    velocity, workspace = Faces.of(mesh), Viscous.of(mesh)
    velocity.x[1:-1], velocity.y[:, 1:-1] = rng.normal(size=(4, 4)), rng.normal(size=(5, 3))
    find_viscosities(GAS, 0.7, Geometry.of(mesh), state.density, state.temperature, workspace)
    stress_force(Geometry.of(mesh), velocity, workspace)
    force = linear.stress @ np.concatenate([velocity.x[1:-1].ravel(), velocity.y[:, 1:-1].ravel()])
    wanted = np.concatenate([workspace.force.x[1:-1].ravel(), workspace.force.y[:, 1:-1].ravel()])
    assert force == pytest.approx(wanted, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_viscous_mode_grows_in_a_run_at_its_rate(integrator):
    """The exchange of mass between two clusters; without viscosity it grows by a third more slowly."""
    steady = steady_state(GAS, VIBRATING, Mesh.rectangle((16, 32), 2.0), 0.0235, 2)
    mode = growth_of(steady, 200.0, 1, viscosity=1.0)[1].modes[0]
    assert mode.growth_rate.real > 1.3 * growth_of(steady, 200.0, 1)[1].rate
    assert rate_of(integrator, steady, mode, 1.0) == pytest.approx(mode.growth_rate.real, rel=0.01)


def test_a_mode_of_shear_is_kept_at_a_sound_size():
    """Its density changes little: what is as large as asked for is then its Mach number."""
    steady = steady_state(GAS, VIBRATING, Mesh.rectangle((16, 16), 1.0), 0.0235, 1)
    (growth,) = growth_of(steady, 200.0, 12, viscosity=1e-2)
    for mode in growth.modes:
        state = with_mode(steady.state, mode, 1e-3)
        change = np.max(np.abs(state.density / steady.state.density - 1.0))
        assert max(change, state.mach.max()) == pytest.approx(1e-3, rel=1e-2)


def test_odd_perturbations_vanish_at_the_mirror():
    steady = steady_state(GAS, VibratingWall(strength=0.228), Mesh.rectangle((16, 32), 2.0), 0.0235, 2)
    antisymmetric = growth_of(steady, 200.0)[1]
    density = antisymmetric.modes[0].density
    assert density == pytest.approx(-density[:, ::-1])
    assert odd(steady.balance.mesh).leak[:, :-1].max() == 0.0
    state = with_mode(steady.state, antisymmetric.modes[0], 1e-3)
    assert np.max(np.abs(state.density / steady.state.density - 1.0)) == pytest.approx(1e-3)
    assert state.mass == pytest.approx(steady.state.mass, rel=1e-12)


def test_without_friction_a_constant_potential_is_no_mode():
    state = steady_state(GAS, VibratingWall(strength=0.228), Mesh.rectangle((16, 16)), 0.0235, 1).state
    rates = [
        mode.growth_rate.real
        for mode in Linearization(state, VibratingWall(strength=0.228), math.inf, even(state.mesh)).leading()
    ]
    assert max(rates) < -0.01


def test_the_cubic_between_two_points_goes_through_them():
    family = Family(Balance.of(GAS, VibratingWall(strength=0.228), Mesh.rectangle((16, 16)), 0.0235), "f")
    (start,) = ExtendedBranch(family).bifurcations(np.linspace(0.026, 0.031, 6))
    points = list(zip(range(3), follow(family, start, (0.026, 0.031), 0.2), strict=False))
    (_, before), (_, after) = points[1:]
    assert between(family, before, after, 0.0) == pytest.approx(before.vector)
    assert between(family, before, after, 1.0) == pytest.approx(after.vector)
    middle, _ = family.corrected(between(family, before, after, 0.5), before.tangent)
    assert np.max(np.abs(middle - between(family, before, after, 0.5))) < 0.02


def test_a_state_that_is_not_there_is_a_failure_with_reasons():
    with pytest.raises(RunFailed, match=r"no localized state found:\n  on 16 x 16 cells, .*: the extended state again"):
        steady_state(GAS, VibratingWall(strength=0.228), Mesh.rectangle((16, 16)), 0.01, 1)
    with pytest.raises(RunFailed, match="the gas packs, its gap 1 - n/n_p falls below 9e-14 at x ="):
        steady_state(GAS, VibratingWall(strength=0.228), Mesh.rectangle((16, 16)), 0.9, 0)
    with pytest.raises(RunFailed, match=r"no branch comes to f = 0\.005; bifurcations .* nearby: none"):
        steady_state(GAS, VibratingWall(strength=0.228), Mesh.rectangle((16, 16)), 0.005, 1, search="branch")


def test_a_system_that_cannot_be_solved_is_a_failure_without_traceback():
    from scipy import sparse

    with pytest.raises(RunFailed, match="a system of linear equations cannot be solved"):
        Bordered(sparse.csc_array(np.zeros((2, 2))), np.ones((2, 1)), np.ones((1, 2)), np.zeros((1, 1)))


def test_growth_rates_that_are_not_found_are_a_failure(monkeypatch):
    def fails(*arguments, **more):
        raise ArpackNoConvergence("no convergence", np.array([]), np.array([]))

    monkeypatch.setattr("hydro.steady.spectrum.eigs", fails)
    state = steady_state(GAS, VibratingWall(strength=0.228), Mesh.rectangle((8, 8)), 0.0235, 0).state
    with pytest.raises(RunFailed, match=r"no growth rates found, symmetric perturbations: .*no convergence"):
        Linearization(state, VibratingWall(strength=0.228), 200.0, even(state.mesh)).leading()


def test_a_branch_that_is_lost_does_not_end_the_search(monkeypatch):
    """Nor does one that ends before its first point; all of that is told."""

    def lost(family, start, limits, longest):
        yield from ()
        if start.value > 0.02:
            raise RunFailed("lost, for this test")

    monkeypatch.setattr("hydro.steady.bifurcation.follow", lost)
    with pytest.raises(RunFailed, match=r"nearby: 0\.01\S*, 0\.02\S*\n  from 0\.02\S*: lost, for this test$"):
        steady_state(GAS, VibratingWall(strength=0.228), Mesh.rectangle((16, 16)), 0.021, 1, search="branch")


# Decks


def test_a_steady_deck(run_text, tmp_path):
    folder, code, _ = run_text(STEADY)
    summary = summary_of(folder)
    assert code == 0
    assert summary["cells"] == [16, 16] and summary["wave"] == 1 and summary["stable"] is True
    assert summary["growth_rate"] == pytest.approx(summary["sectors"][0]["growth_rates"][0])
    assert {"area_fraction", "aspect_ratio", "L", "wall_max", "wall_min", "gas_density", "residual"} <= summary.keys()
    assert {"newton_iterations", "wall_seconds"} <= summary.keys()
    for picture in ("density.png", "density.pdf", "modes.png", "modes.pdf"):
        assert (folder / "pictures" / picture).stat().st_size > 1000
    saved = read_checkpoint(folder / "checkpoints" / "steady.h5")
    assert saved.mesh.integral(saved.conserved[0]) == pytest.approx(0.0235, rel=1e-12)


def test_as_many_modes_as_wanted_are_listed(run_text):
    """Those of largest growth rate, sound among them: a pair counts once."""
    folder, code, _ = run_text(STEADY, "steady.wave=0", "steady.modes=12")
    sectors = summary_of(folder)["sectors"]
    assert code == 0 and {len(sector["growth_rates"]) for sector in sectors} == {12}
    assert all(sector["growth_rates"] == sorted(sector["growth_rates"], reverse=True) for sector in sectors)
    assert any(frequency > 2.0 for frequency in sectors[0]["frequencies"][:2])


def test_growth_rates_are_those_of_the_viscous_gas(run_text):
    plain, viscous = (
        summary_of(run_text(STEADY, "steady.wave=0", f"gas.viscosity={factor}", name=name)[0])["growth_rate"]
        for factor, name in ((0, "plain"), (1, "viscous"))
    )
    assert 1.5 < viscous / plain < 2.2
    first = []
    for factor in (0, 1):
        folder, _, _ = run_text(BRANCH, "branch.points=1", f"gas.viscosity={factor}", name=f"branch{factor}")
        first.append(summary_of(folder)["points"][0]["growth_rate"])
    assert 1.5 < first[1] / first[0] < 3.0


@pytest.mark.parametrize("text", [STEADY, BRANCH])
def test_what_the_deck_does_not_give_is_said_with_the_result(text, tmp_path, capsys):
    deck = tmp_path / "deck.toml"
    deck.write_text(text)
    folder = tmp_path / "run"
    words = [str(deck), "gas.tau=100", "--output", str(folder), "--overwrite"]
    if text is BRANCH:
        words[1:1] = ["branch.points=1"]
    assert main(words) == 0
    told = "for K = 0.002, tau = 100, viscosity = 0, W = 114; not in the deck, and assumed: gas.K = 0.002, wall.W = 114"
    assert told in capsys.readouterr().out
    assert summary_of(folder)["assumed"] == {"gas.K": 2e-3, "wall.W": 114.0}
    assert main(["report", str(folder), "--quiet"]) == 0
    page = (folder / "report.html").read_text()
    assert told in page
    assert main([*words, "gas.K=1e-3", "wall.kind=vibrating", "wall.W=100"]) == 0
    told = capsys.readouterr().out
    assert "for K = 0.001, tau = 100, viscosity = 0, W = 100\n" in told and "assumed" not in told


def test_defaults_are_the_same_for_all_kinds():
    """But for K and tau of steady states, which say so, and what a kind requires or leaves out."""
    sections = {
        "gas": (Gas, ViscousGas, FlowingGas, SteadyGas, BranchGas, GrainsGas),
        "box": (Box, ClosedBox),
        "time": (Time, Timeline),
    }
    defaults: dict[str, dict[str, Any]] = {}
    for name, models in sections.items():
        for model in models:
            for key, value in model.model_fields.items():
                defaults.setdefault(f"{name}.{key}", {})[model.__name__] = (
                    "required" if value.is_required() else value.default
                )
    differing = {key for key, values in defaults.items() if len(set(map(repr, values.values()))) > 1}
    assert differing == {"gas.K", "gas.L", "gas.f", "gas.tau"}
    assert all(values.get("SteadyGas") == values["BranchGas"] for values in (defaults["gas.K"], defaults["gas.tau"]))
    assert {repr(value) for value in defaults["gas.K"].values()} == {"'required'", "0.002"}
    assert {repr(value) for value in defaults["gas.tau"].values()} == {"inf", "200.0"}
    for key in ("gas.L", "gas.f"):  # required, or not where the branch is followed in it
        assert {repr(value) for value in defaults[key].values()} == {"'required'", "None"}


def test_an_evolution_starts_from_a_steady_state_and_stays(run_text, tmp_path):
    folder, _, _ = run_text(STEADY)
    path = folder / "checkpoints" / "steady.h5"
    evolution = f"""
kind = "evolution"
gas = {{ L = 5e4, K = 2e-3, tau = 200.0 }}
mesh = {{ cells = [16, 16] }}
wall = {{ kind = "vibrating" }}
initial = {{ kind = "checkpoint", path = "{path}" }}
time = {{ end = 1.0 }}
"""
    after, code, _ = run_text(evolution, name="after")
    assert code == 0
    (last,) = after.glob("checkpoints/*.h5")
    assert read_checkpoint(last).conserved[0] == pytest.approx(read_checkpoint(path).conserved[0], rel=1e-10)


def test_clusters_in_the_middle(run_text):
    corners, _, _ = run_text(STEADY, "steady.wave=2", "box.aspect_ratio=2.0", "mesh.cells=[16,32]")
    middle, _, _ = run_text(
        STEADY, "steady.wave=2", "box.aspect_ratio=2.0", "mesh.cells=[16,32]", "steady.shifted=true", name="middle"
    )
    first, second = (read_checkpoint(folder / "checkpoints" / "steady.h5").conserved[0] for folder in (corners, middle))
    assert first[0].argmax() in (0, 31) and second[0].argmax() in (15, 16)
    assert np.roll(first, 16, axis=1) == pytest.approx(second)
    assert [sector["sector"] for sector in summary_of(middle)["sectors"]] == ["symmetric", "antisymmetric"]
    assert not summary_of(corners)["stable"] and not summary_of(middle)["stable"]


def test_the_extended_state_gives_way_to_a_half_wave(run_text):
    folder, code, _ = run_text(STEADY, "steady.wave=0")
    summary = summary_of(folder)
    assert code == 0 and not summary["stable"]
    rates = {sector["sector"]: sector["growth_rates"][0] for sector in summary["sectors"]}
    assert rates["1 half-wave"] == summary["growth_rate"] > 0.0 > rates["0 half-waves"]
    assert summary["wall_max"] == pytest.approx(summary["wall_min"])


def test_a_branch_deck(run_text):
    folder, code, _ = run_text(BRANCH)
    summary = summary_of(folder)
    assert code == 0 and summary["completed"]
    (fold,), (start,) = summary["folds"], summary["bifurcations"]
    assert start["direction"] == "subcritical" and start["f"] < fold["f"] < 0.031
    assert fold["growth_rate"] == pytest.approx(0.0, abs=1e-6)
    assert summary["hysteresis"] == [{"branch": "branch 1", "from": start["f"], "to": fold["f"]}]
    branch = [point for point in summary["points"] if point["branch"] != "extended"]
    assert branch[0]["stable"] is False and branch[-1]["stable"] is True
    assert branch[-1]["f"] == pytest.approx(0.0265, rel=1e-12)
    rows = (folder / "points.csv").read_text().splitlines()
    assert len(rows) == len(summary["points"]) + 1
    assert all((folder / "checkpoints" / point["checkpoint"]).exists() for point in summary["points"])
    assert (folder / "pictures" / "branches.pdf").stat().st_size > 1000


def test_a_branch_that_ends_at_its_longest_keeps_its_points(run_text):
    folder, code, _ = run_text(BRANCH, "branch.points=3")
    summary = summary_of(folder)
    assert code == 0
    assert len([point for point in summary["points"] if point["branch"] != "extended"]) == 3


def test_without_a_bifurcation_the_extended_states_are_kept(run_text):
    folder, code, error = run_text(BRANCH, "branch.start=0.0305", "branch.stop=0.031")
    assert code == 3
    assert "no bifurcation: between f = 0.0305 and 0.031 a perturbation of 1 half-wave(s)" in error
    assert "5 points are saved" in error
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["completed"] is False and len(summary["points"]) == 5


def test_a_parameter_that_the_closure_does_not_offer_is_refused_by_name(run_text, monkeypatch):
    monkeypatch.setattr(Grossman, "parameters", lambda self: ())
    folder, code, error = run_text(BRANCH, "branch.parameter=L", "gas.f=0.0235")
    assert code == 2 and not folder.exists()
    assert "branch.parameter: 'L' is not known; known: f, aspect_ratio" in error


@pytest.mark.parametrize("key", ["wall.W", "gas.L", "gas.K", "gas.f"])
@pytest.mark.parametrize("value", ["1e300", "1e-300"])
def test_numbers_beyond_all_bounds_are_refused_by_name(run_text, key, value):
    folder, code, error = run_text(STEADY, f"{key}={value}")
    assert code == 2 and f"{key}: " in error and not folder.exists()


@pytest.mark.parametrize("override", ["wall.W=1e30", "gas.L=1e30", "gas.L=1e-30", "gas.K=1e30", "gas.f=1e-30"])
@pytest.mark.filterwarnings("error")
def test_numbers_beyond_all_reason_fail_with_a_message(run_text, override):
    _, code, error = run_text(STEADY, override)
    assert code in (0, 3) and "Traceback" not in error


def test_a_mode_too_strong_for_the_gas_is_refused_before_anything_is_written(run_text):
    folder, code, error = run_text(STEADY, "steady.wave=0", "gas.f=0.1", "steady.mode_amplitude=0.49")
    assert code == 2 and "steady.mode_amplitude: 0.49 is too large, 1 half-wave:" in error
    assert not folder.exists()


def test_a_wide_box_has_more_modes_than_letters(run_text):
    folder, code, _ = run_text(STEADY, "steady.wave=0", "box.aspect_ratio=40.0", "mesh.cells=[8,160]")
    assert code == 0 and len(summary_of(folder)["sectors"]) > 26
    assert (folder / "pictures" / "modes.png").stat().st_size > 1000


def test_lines_of_a_diagram_change_where_the_growth_rate_is_zero():
    numbers = {"L": 1.0, "aspect_ratio": 1.0, "wall_min": 0.1}
    rows = [
        {**numbers, "f": f, "wall_max": 2 * f, "growth_rate": rate, "stable": rate < 0.0}
        for f, rate in ((0.1, 3.0), (0.2, 1.0), (0.3, -1.0))
    ]
    (unstable, first), (stable, second) = stretches(rows)
    assert (unstable, stable) == (False, True)
    assert [row["f"] for row in first] == pytest.approx([0.1, 0.2, 0.25])
    assert [(row["f"], row["wall_max"]) for row in second] == [pytest.approx((0.25, 0.5)), (0.3, 0.6)]


@pytest.mark.parametrize(
    ("text", "override", "complaint"),
    [
        (STEADY, "steady.wave=3", "steady.wave: 3 is not allowed; mesh.cells[1] = 16 must be a multiple of it"),
        (STEADY, "wall.kind=elastic", "wall.kind: 'elastic' is not known; known: vibrating, thermal"),
        (STEADY, "steady.shifted=1", "steady.shifted: 1 is not allowed; must be true or false"),
        (STEADY, "steady.search=brunch", "did you mean 'branch'?"),
        (STEADY, "wall.W=0", "wall.W: 0 is not allowed; must be greater than 0"),
        (STEADY, "box.periodic=[\"y\"]", "box.periodic: unknown key; known: aspect_ratio"),
        (BRANCH, "branch.parameter=L", "gas.f: required, since the branch is followed in L"),
        (BRANCH, "branch.stop=0.0265", "branch.stop: 0.0265 is not allowed; must differ from branch.start"),
        (BRANCH, "branch.stop=1.5", "branch.stop: 1.5 is not allowed; must be less than 1"),
    ],
)  # fmt: skip
def test_bad_decks_are_refused(run_text, text, override, complaint):
    folder, code, error = run_text(text, override)
    assert code == 2 and complaint in error
    assert not folder.exists()


@pytest.mark.parametrize("text", [STEADY, BRANCH])
def test_check_describes(tmp_path, capsys, text):
    deck = tmp_path / "deck.toml"
    deck.write_text(text)
    assert main(["check", str(deck)]) == 0
    told = capsys.readouterr().out
    assert "growth rates per unit of time, L_x/T_*^(1/2), for K = 0.002, tau = 200, viscosity = 0, W = 114" in told
    assert "not in the deck, and assumed: gas.K = 0.002, gas.tau = 200, wall.W = 114" in told
