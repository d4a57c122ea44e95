"""Extended states, their marginal stability, and decks of kind "stability"."""

from __future__ import annotations

import json
import math
from typing import NamedTuple

import numpy as np
import pytest
from conftest import summary_of
from scipy.linalg import eigh

from hydro.cli import main
from hydro.deck import dumps, parse
from hydro.deck.stability import AreaFractions
from hydro.errors import DeckError, RunFailed, Stopped
from hydro.gas import Grossman, HardDisks
from hydro.kinds import stability
from hydro.progress import counted
from hydro.steady import marginal
from hydro.steady.elements import reference_element
from hydro.steady.extended import extended_state
from hydro.steady.grossman_limits import dilute_aspect_ratio, dilute_end
from hydro.steady.marginal import aspect_ratio_of, critical_aspect_ratio, principal_mode, tongue, vanishing_tongue
from hydro.steady.uniform_pressure import UniformPressure
from hydro.walls import ThermalWall, VibratingWall

MINIMAL = """
kind = "stability"
stability = { L = [5e4], f = [0.01, 0.0235, 0.03], walls = ["vibrating", "thermal"], waves = [1, 2] }
"""


def gas(L=5e4):
    return Grossman(L, 2e-3)


@pytest.mark.parametrize("w", [-5000.0, -800.0, -40.0, -1.0, 0.0, 3.0, 12.0])
def test_functions_of_w_and_their_slopes(w):
    """Against the closure itself where 1-n is a number, and finite differences."""
    disks, h = UniformPressure.of(gas()), 1e-3
    names = {"cooling": "cooling_slope", "temperature": "temperature_slope"}
    if w > -700.0:
        for function, slope in names.items():
            difference = np.log(getattr(disks, function)(w + h) / getattr(disks, function)(w - h)) / (2.0 * h)
            assert getattr(disks, slope)(w) == pytest.approx(difference, abs=1e-6)
    if w > -3.0:
        n = 1.0 / (1.0 + math.exp(w))
        closure, T = gas()._replace(K=1.0, L=1.0), gas().temperature(n, 1.0)
        assert disks.temperature(w) == pytest.approx(T, rel=1e-12)
        assert math.exp(0.5 * w) * disks.cooling(w) == pytest.approx(closure.cooling(n, T), rel=1e-12)
        assert math.exp(0.5 * w) * disks.wall_supply(w) == pytest.approx(n * math.sqrt(T), rel=1e-12)
        flux = closure.conductivity(n, T) * T * disks.temperature_slope(w)
        assert math.exp(0.5 * w) * disks.conductance(w) == pytest.approx(flux, rel=1e-12)
    assert np.isfinite([disks.conductance(w), disks.cooling(w), disks.potential(w), disks.wall_supply_slope(w)]).all()


def test_elements_integrate_and_differentiate_polynomials():
    element = reference_element(8)
    r = element.nodes
    np.testing.assert_allclose(element.derivative @ r**8, 8.0 * r**7, atol=1e-12)
    np.testing.assert_allclose(element.integral @ r**7, (r**8 - 1.0) / 8.0, atol=1e-14)
    assert element.weights @ r**14 == pytest.approx(2.0 / 15.0, rel=1e-13)
    assert np.all(element.derivative @ np.ones(9) == 0.0) or np.abs(element.derivative @ np.ones(9)).max() < 1e-13


@pytest.mark.parametrize(("L", "f"), [(1e2, 1e-5), (5e4, 0.0235), (1e8, 0.9), (1e-6, 0.3), (1e4, 1.0 - 1e-6)])
def test_a_state_solves_its_equations(L, f):
    state = extended_state(gas(L), f)
    x = np.linspace(0.0, 1.0, 2001)
    w = state.log_void_at(x)
    assert w.shape == x.shape and w[0] == state.w0
    assert state.log_void_at(0.5) == pytest.approx(w[1000], rel=1e-12) and np.shape(state.log_void_at(0.5)) == ()
    assert np.all(np.diff(w) > 0.0)
    assert (state.x[0], state.x[-1]) == (0.0, 1.0) and np.all(np.diff(state.x) > 0.0)
    np.testing.assert_allclose(state.log_void_at(state.x), state.w, rtol=1e-12, atol=1e-10)
    nodes, weights = np.polynomial.legendre.leggauss(6)
    half = 0.5 * np.diff(state.x)[:, None]  # the front of a cluster is thin: Gauss's rule between nodes
    inside = state.density_at(state.x[:-1, None] + half * (1.0 + nodes))
    assert np.sum(half * inside * weights) == pytest.approx(f, rel=1e-11)
    assert state.wall_density == pytest.approx((state.density_at(0.0), state.density_at(1.0)), rel=1e-12)


def test_walls_set_the_pressure_and_the_temperature():
    state = extended_state(gas(), 0.0235)
    assert state.temperature_at(1.0, ThermalWall(1.7)) == pytest.approx(1.7, rel=1e-13)
    weak, strong = VibratingWall(strength=0.228), VibratingWall(strength=0.456)
    assert state.pressure(strong) == pytest.approx(2.0 * state.pressure(weak), rel=1e-14)
    x = np.array([[0.1, 0.2], [0.3, 0.4]])
    n, T = state.density_at(x), state.temperature_at(x, weak)
    np.testing.assert_allclose(gas().pressure(n, T), state.pressure(weak), rtol=1e-12)
    assert extended_state(gas()._replace(K=0.0), 0.0235).w0 == state.w0


@pytest.mark.parametrize(
    ("L", "f"), [(0.0, 0.1), (-1.0, 0.1), (math.nan, 0.1), (math.inf, 0.1), (1e4, 0.0), (1e4, 1.0)]
)
def test_no_state_where_none_exists(L, f):
    with pytest.raises(RunFailed, match="it needs losses in collisions and a mean density in 0 < n < 1"):
        extended_state(gas(L), f)


class Fading(NamedTuple):
    """Grossman's gas, but its conduction ends at n = 0.02: the heat cannot come through."""

    L: float
    K: float
    alpha: float = 1.15


class FadingGas(Fading, HardDisks):
    __slots__ = ()
    packing_density = Grossman.packing_density
    pressure_factor = Grossman.pressure_factor
    pressure_factor_slope = Grossman.pressure_factor_slope
    cooling_factor = Grossman.cooling_factor
    cooling_factor_slope = Grossman.cooling_factor_slope

    def conductivity_factor(self, n):
        return np.exp(-(np.minimum(0.02 / n, 5.0) ** 4)) * self.K


def test_a_gas_without_a_state_is_answered_with_what_was_tried():
    with pytest.raises(RunFailed, match=r"no extended state.*x=0"):
        extended_state(FadingGas(5e4, 1.0), 0.0235)


@pytest.mark.parametrize("wall", ["vibrating", "thermal"])
def test_the_principal_mode_is_that_of_a_dense_solver(wall):
    for f in (1e-3, 0.0235, 0.1):
        state = extended_state(gas(), f)
        problem = marginal.Problem.of(state, marginal.WALL_CONDITIONS[wall](state))
        band, root = problem._matrix()
        full = np.diag(band[0])
        for k in range(1, len(band)):
            full += np.diag(band[k, :-k], -k) + np.diag(band[k, :-k], k)
        values, vectors = eigh(full, subset_by_index=(0, 1))
        mode = principal_mode(state, wall)
        assert mode.eigenvalue == pytest.approx(-values[0], rel=1e-7, abs=1e-13)
        dense = vectors[:, 0] / root
        np.testing.assert_allclose(mode.phi[: len(dense)], dense / dense[np.argmax(np.abs(dense))], atol=1e-6)


def test_waves_multiply_the_aspect_ratio():
    state = extended_state(gas(), 0.0235)
    first, third = (critical_aspect_ratio(state, "vibrating", m) for m in (1, 3))
    assert third.aspect_ratio == pytest.approx(3.0 * first.aspect_ratio, rel=1e-14)
    assert first.error < 1e-10
    assert critical_aspect_ratio(extended_state(gas(), 0.5), "vibrating").aspect_ratio is None
    assert aspect_ratio_of(0.0, 1.0) is None


def test_the_tongue_ends_where_aspect_ratios_do():
    found = tongue(gas(), "thermal")
    inside, outside = found.f1 * (1.0 + 1e-9), found.f1 * (1.0 - 1e-9)
    assert critical_aspect_ratio(extended_state(gas(), inside), "thermal").aspect_ratio is not None
    assert critical_aspect_ratio(extended_state(gas(), outside), "thermal").aspect_ratio is None
    at_least = critical_aspect_ratio(extended_state(gas(), found.f_min), "thermal").aspect_ratio
    assert at_least == pytest.approx(found.aspect_ratio_min, rel=1e-12)
    for shift in (0.999, 1.001):
        beside = critical_aspect_ratio(extended_state(gas(), shift * found.f_min), "thermal").aspect_ratio
        assert beside > found.aspect_ratio_min
    with pytest.raises(RunFailed, match="does not vanish between"):
        vanishing_tongue(gas(), "L", "vibrating", 1e4, 2e4)


def test_eq_asymp_begins_at_f1():
    assert dilute_aspect_ratio(gas(), 0.999 * dilute_end(gas())) is None
    assert dilute_aspect_ratio(gas(), 1.001 * dilute_end(gas())) > 1e4


def run(text, tmp_path, *words):
    deck = tmp_path / "deck.toml"
    deck.write_text(text)
    folder = tmp_path / "out"
    return main([str(deck), *words, "--output", str(folder), "--quiet", "--overwrite"]), folder


def test_the_minimal_deck_runs(tmp_path):
    code, folder = run(MINIMAL, tmp_path)
    summary = summary_of(folder)
    assert code == 0 and summary["completed"] and summary["wall_seconds"] > 0.0
    assert [(row["f"], row["wall"], row["m"]) for row in summary["rows"]][:4] == [
        (0.01, "vibrating", 1), (0.01, "vibrating", 2), (0.01, "thermal", 1), (0.01, "thermal", 2),
    ]  # fmt: skip
    assert len(summary["rows"]) == 12 and set(summary["rows"][0]) == {"L", "f", "wall", "m", "aspect_ratio", "error"}
    assert set(summary["tongues"][0]) == {"L", "wall", "f1", "f2", "f_min", "aspect_ratio_min"}
    assert summary["tongues"][0]["aspect_ratio_min"] == pytest.approx(144.8088 / math.sqrt(5e4), rel=1e-6)
    assert all((folder / "pictures" / f"marginal.{suffix}").stat().st_size > 0 for suffix in ("png", "pdf"))
    assert parse((folder / "deck.toml").read_text()) == parse(MINIMAL)


def test_stable_everywhere_is_null(tmp_path):
    code, folder = run(MINIMAL, tmp_path, "stability.L=[100]")
    summary = summary_of(folder)
    assert code == 0
    assert all(row["aspect_ratio"] is None and row["error"] is None for row in summary["rows"])
    assert all(tongue[key] is None for tongue in summary["tongues"] for key in ("f1", "f2", "f_min"))


def test_closing_lines_and_check(tmp_path, capsys):
    (tmp_path / "deck.toml").write_text(MINIMAL)
    assert main(["check", str(tmp_path / "deck.toml"), "stability.L=[100, 5e4]"]) == 0
    assert "6 extended states, 4 critical aspect ratios for each, and 4 tongues" in capsys.readouterr().out
    assert main([str(tmp_path / "deck.toml"), "stability.L=[100, 5e4]", "--output", str(tmp_path / "out")]) == 0
    printed = capsys.readouterr()
    assert "no tongue: stable for every aspect ratio" in printed.out and "12 of 24 points" in printed.out
    assert "out: 100%" in printed.err and "s left" in printed.err


def test_a_failure_keeps_what_is_finished(tmp_path, monkeypatch, capsys):
    def fails_at(gas, f, *rest, **more):
        if f == 0.03:
            raise RunFailed("no extended state: for this test")
        return extended_state(gas, f, *rest, **more)

    monkeypatch.setattr(stability, "extended_state", fails_at)
    code, folder = run(MINIMAL, tmp_path)
    summary = json.loads((folder / "summary.json").read_text())
    assert code == 3 and not summary["completed"] and len(summary["rows"]) == 8
    assert "8 rows are finished and saved" in capsys.readouterr().err
    assert (folder / "pictures" / "marginal.png").exists()


def test_a_signal_keeps_what_is_finished(tmp_path, monkeypatch):
    looks = []

    def check(self, where):
        looks.append(where)
        if len(looks) == 2:
            raise Stopped(f"stopped {where}")

    monkeypatch.setattr(stability.StopOnSignal, "check", check)
    code, folder = run(MINIMAL, tmp_path)
    assert code == 4 and len(summary_of(folder)["rows"]) == 4


def test_counted_passes_all_items_on(capsys):
    assert list(counted([1, 2, 3], "title", quiet=True)) == [1, 2, 3]
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("override", "key", "problem", "nearest"),
    [
        ("stability.f=3", "stability.f", "must be a list", None),
        ("stability.f=[2]", "stability.f[0]", "must be less than 1", None),
        ("stability.f=[]", "stability.f", "must have an item", None),
        ("stability.f=[0.1, 0.1]", "stability.f", "must not repeat", None),
        ("stability.f={start=0.1, stop=0.05, count=3}", "stability.f.stop", "must be greater than start, 0.1", None),
        ("stability.f={start=0.1, stop=0.5, count=1}", "stability.f.count", "must be at least 2", None),
        ("stability.f={start=0.1, stop=0.5, count=3, spacing='lg'}", "stability.f.spacing", "known: linear", "log"),
        ("stability.f={start=0.1, stop=0.5, cont=3, count=3}", "stability.f.cont", "unknown key", "count"),
        ("stability.f={start=0.1, count=3}", "stability.f.stop", "required: the last", None),
        ("stability.L=[0]", "stability.L[0]", "must be greater than 0", None),
        ("stability.walls=['elastic']", "stability.walls[0]", "known: vibrating, thermal", None),
        ("stability.waves=[0]", "stability.waves[0]", "must be at least 1", None),
        ("stability.points=[{f=2, aspect_ratio=1}]", "stability.points[0].f", "must be less than 1", None),
        ("stability.points=[{f=0.1}]", "stability.points[0].aspect_ratio", "required: its aspect ratio", None),
        ("stability.points=[{f=0.1, aspect_ratio=1, labl='a'}]", "stability.points[0].labl", "unknown key", "label"),
        ("stability.points=[3]", "stability.points[0]", "must be a section", None),
        ("gas.L=1", "gas.L", "unknown key", "stability.L"),
    ],
)
def test_complaints(override, key, problem, nearest):
    with pytest.raises(DeckError) as caught:
        parse(MINIMAL, [override])
    found = {complaint.key: complaint for complaint in caught.value.complaints}
    assert list(found) == [key] and problem in found[key].problem and found[key].nearest == nearest


def test_ranges_of_area_fractions_and_the_way_back_to_toml():
    deck = parse(MINIMAL, ["stability.f={start=0.01, stop=0.04, count=3, spacing='log'}"])
    assert deck.stability.area_fractions == pytest.approx((0.01, 0.02, 0.04), rel=1e-14)
    assert AreaFractions(start=0.1, stop=0.3, count=3).values == pytest.approx((0.1, 0.2, 0.3), rel=1e-14)
    deck = parse(MINIMAL, ["stability.points=[{f=0.1, aspect_ratio=2.0, label='a \"b\"'}]"])
    assert parse(dumps(deck)) == deck
