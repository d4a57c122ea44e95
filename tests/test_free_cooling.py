"""A periodic gas that cools freely: its start, its clock, its observables, and that it gets through."""

from __future__ import annotations

import math

import numpy as np
import pytest
from conftest import PROBLEMS, differences, outcome, restart, summary_of
from zygote import draw_nothing

from hydro.check.scales import report, scales
from hydro.cli import main
from hydro.deck import load, parse
from hydro.driver.clock import collision_clock
from hydro.driver.march import Run, advance
from hydro.dynamics import Godunov
from hydro.errors import RunFailed
from hydro.exact.cooling_modes import cooling_modes, critical_wave_numbers
from hydro.gas import Grossman
from hydro.initial import initial_state
from hydro.mesh import Mesh
from hydro.observables import observables_of
from hydro.observables.cooling import structure
from hydro.output.history import read_rows
from hydro.setup import integrator_of
from hydro.state import State

DECK = str(PROBLEMS / "free_cooling.toml")
SMALL = ("mesh.cells=[16,16]", "time.end=3.0", "output.times=[1.0,3.0]", "output.movie=false", "output.collisions=[20]")
INELASTIC = 3.0 * 2.26 / 32.0 * 35870.0 * 5e-3**2  # 1 - r^2


def deck(*overrides):
    return load(DECK, overrides)


def test_noise_of_the_velocity_has_its_size_and_no_momentum():
    quiet, noisy, other = (
        initial_state(deck("initial.amplitude=0.3", *more))
        for more in (["initial.velocity=0.0"], ["initial.velocity=0.2"], ["initial.velocity=0.2", "initial.seed=2"])
    )
    np.testing.assert_array_equal(quiet.conserved[0], noisy.conserved[0])
    assert not quiet.conserved[1:3].any()
    for component, momentum in zip(noisy.velocity, noisy.conserved[1:3], strict=True):
        assert np.std(component) == pytest.approx(0.2, rel=0.03)
        assert abs(noisy.mesh.integral(momentum)) < 1e-15
    np.testing.assert_allclose(noisy.temperature, 1.0, rtol=1e-12)
    assert (noisy.conserved[1] != other.conserved[1]).all()


def test_collisions_per_grain_follow_haffs_law():
    """Each costs (1-r^2) T of two grains, so T = exp(-(1-r^2) C/2)."""
    uniform = deck("initial.velocity=0.0", "mesh.cells=[8,8]")
    state = initial_state(uniform)
    run = Run(state, integrator_of(uniform, state), 3.0, dt_max=2e-3, clock=collision_clock(uniform))
    while state.time < run.end:
        advance(run, run.end)
    expected = -2.0 * math.log(float(state.temperature[0, 0])) / INELASTIC
    assert run.reading["collisions_per_grain"] == pytest.approx(expected, rel=1e-4) and expected > 50.0
    assert "collisions_per_grain" not in run.ledger.balance(state.energy)


def test_only_a_periodic_gas_that_cools_has_a_clock(capsys):
    assert collision_clock(deck("box.periodic=['y']", "output.collisions=[]")) is None
    assert observables_of(deck()).name == "cooling"
    assert observables_of(deck("box.periodic=['x']")).name == "clustering"
    assert main([DECK, *SMALL, "gas.L=0.0", "--quiet"]) == 2
    assert "output.collisions" in capsys.readouterr().err


def test_a_run_goes_on_by_its_clock_after_a_restart(run_deck, monkeypatch):
    draw_nothing(monkeypatch.setattr)
    whole, code = run_deck("free_cooling", *SMALL, "output.checkpoint_every=0.4", folder="whole")
    assert code == 0
    expected = outcome(whole)
    rows = summary_of(whole)["snapshots"]
    assert [row["time"] for row in rows][1:] == [1.0, 3.0]
    assert 20.0 <= rows[0]["collisions_per_grain"] < 22.0
    history = read_rows(whole / "history.csv")
    assert (np.diff(history["collisions_per_grain"]) > 0.0).all()
    assert (history["first_order_cells"] == 0).all() and summary_of(whole)["first_order_cells"] == 0
    part, code = run_deck("free_cooling", *SMALL, "output.checkpoint_every=0.4", "time.wall_limit=1e-9", folder="part")
    assert code == 4 and restart(part, "time.wall_limit=inf") == 0
    ignored = {"deck"}
    assert set(differences(part, expected)) <= ignored


def test_times_may_be_a_range_and_must_increase(capsys):
    assert deck().output_times == pytest.approx([0.4 * 10 ** (k / 2) for k in range(7)])
    for wrong in ("output.times={start=2.0,stop=1.0,count=3}", "output.times={start=1.0,stop=1e3,count=3}"):
        assert main(["check", DECK, wrong]) == 2
        assert "output.times" in capsys.readouterr().err


def test_structure_factors_of_a_wave():
    """All power is at its wave number: half the square of the amplitude, over the wave vectors of its shell."""
    mesh = Mesh.rectangle((32, 64), aspect_ratio=2.0, periodic=("x", "y"))
    k = 2.0 * math.pi * 3.0
    wave = np.cos(k * mesh.y) * np.ones(mesh.cells)
    state = State.of(Grossman(5e4, 2e-3), mesh, 0.1 * (1.0 + 0.01 * wave), 4.0, (0.2 * wave, 0.0))
    found = structure(state)
    top = int(np.argmax(found.density))
    assert found.wave_numbers[top] == pytest.approx(k)
    assert np.argmax(found.across) == top and found.along.max() < 1e-4 * found.across[top]
    shells = np.rint(np.hypot(*np.meshgrid(np.fft.fftfreq(32, 1 / 64), np.fft.fftfreq(64, 1 / 64), indexing="ij")))
    members = int((shells == 6).sum())
    assert found.density[top] * members == pytest.approx(0.5 * 0.01**2, rel=1e-10)
    assert found.across[top] * members == pytest.approx(0.5 * 0.2**2 / 4.0, rel=1e-3)


def test_critical_wave_numbers_are_where_growth_ends():
    for n in (0.05, 0.2, 0.5):
        gas = Grossman(35870.0, 5e-3)
        for name, k in critical_wave_numbers(gas, n).items():
            below, at, above = (cooling_modes(gas, n, factor * k)[name].rate.real for factor in (0.9, 1.0, 1.1))
            assert below > 0.0 > above and abs(at) < 1e-9 * (below - above)


def test_dilute_nearly_elastic_gas_has_the_known_critical_length():
    """L_s = pi^(3/2) d/(2 phi (1-r^2)^(1/2)) for the cooling and the viscosity of kinetic theory (Boltzmann)."""
    n, d = 1e-3, 5e-3
    gas = Grossman(L=100.0, K=d)
    length = 2.0 * math.pi / critical_wave_numbers(gas, n)["shear"]
    ratio = 2.41 / 1.42  # of mu from conduction, that viscosity goes by, to mu from cooling, at mu = 1 each off
    loss = 3.0 * 2.26 / 32.0 * 100.0 * d**2
    expected = math.pi**1.5 * d / (2.0 * 0.9069 * n * loss**0.5)
    assert length == pytest.approx(expected * ratio**-0.5, rel=0.02)


def test_check_tells_critical_lengths_and_a_sane_number_of_steps(run_deck, monkeypatch):
    draw_nothing(monkeypatch.setattr)
    asked = ("mesh.cells=[32,32]", "time.end=100.0", "output.times=[]", "output.movie=false")
    small = deck(*asked)
    told = {scale.name: scale.value for scale in scales(small, initial_state(small))}
    folder, code = run_deck("free_cooling", *asked)
    steps = summary_of(folder)["steps"]
    assert code == 0 and 0.4 * steps < told["steps"] < 2.5 * steps
    assert told["critical length, clusters"] > told["critical length, shear"] > 0.1
    assert any(line.startswith("critical length, shear") for line in report(small))


STARTS = """
kind = "evolution"
gas = {{ L = {L}, f = {n}, K = 5e-3, viscosity = 1.0 }}
box = {{ periodic = ["x", "y"] }}
mesh = {{ cells = [48, 48] }}
wall = {{ kind = "elastic" }}
initial = {{ kind = "noise", amplitude = 0.0, velocity = 0.1, seed = {seed} }}
time = {{ end = 1e3 }}
"""


def follow(made, collisions):
    """Steps, or the words by which it stopped, of a start of benchmarks/free_cooling.py."""
    state = initial_state(made)
    run = Run(state, integrator_of(made, state), made.time.end, clock=collision_clock(made))
    try:
        while run.reading["collisions_per_grain"] < collisions:
            advance(run, run.end)
    except RunFailed as error:
        return run, str(error)
    return run, ""


def test_a_gas_of_which_a_cell_would_lose_all_its_heat_gets_through(monkeypatch):
    """One of forty starts of benchmarks/free_cooling.py; eleven of them stop without first-order fluxes."""
    made = parse(STARTS.format(L=35870.0 * 0.36 / 0.19, n=0.4, seed=0))
    run, words = follow(made, 130.0)
    counts = run.integrator.counts()
    assert words == "" and run.rejected == 0 and counts["first_order_cells"] > 0
    assert run.ledger.balance(run.state.energy)["residual"] == pytest.approx(0.0, abs=1e-12)
    monkeypatch.setattr(Godunov, "_careful_flow", Godunov._flow)
    run, words = follow(made, 130.0)
    assert "no step is possible" in words
