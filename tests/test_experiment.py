"""Decks in physical units: what follows from an experiment, what is refused, and how well the equations hold for it."""

from __future__ import annotations

import csv
import json
import math
import tomllib

import numpy as np
import pytest
from conftest import PROBLEMS, summary_of
from hypothesis import given, settings
from hypothesis import strategies as st

from hydro.check.regime import ASSUMPTIONS, FLUID, SMALL, Place, position, stripe_of
from hydro.cli import main
from hydro.deck import dumps, load, parse
from hydro.errors import DeckError
from hydro.steady.marginal import critical_aspect_ratio

TABLE = {
    "d": "2 mm", "L_x": "20 cm", "L_y": "0.3 m", "N": 1000, "r": 0.9, "A": "1 mm", "frequency": "50 Hz", "mu": 2.0,
    "rolling_friction": 1e-3, "gravity": "10 m/s^2",
}  # fmt: skip
REST = """
mesh = { cells = [16, 16] }
initial = { kind = "cosine" }
time = { end = 1.0 }
"""
STEADY = "mesh = { cells = [16, 16] }\nsteady = { wave = 0 }"
BRANCH = 'mesh = { cells = [16, 16] }\nbranch = { parameter = "f", start = 0.02, stop = 0.06 }'
STABILITY = "stability = { f = [0.02, 0.04] }"
KINDS = {"evolution": REST, "steady": STEADY, "branch": BRANCH, "stability": STABILITY}


def deck(kind="evolution", *overrides, table=TABLE, **changes):
    """A deck of an experiment; a change to None takes a key away."""
    given_keys = {key: value for key, value in {**table, **changes}.items() if value is not None}
    section = "\n".join(f"{key} = {json.dumps(value)}" for key, value in given_keys.items())
    return parse(f'kind = "{kind}"\n{KINDS[kind]}\n[experiment]\n{section}\n', overrides)


def complaints(*overrides, kind="evolution", **changes):
    """The complaints about such a deck, by key."""
    with pytest.raises(DeckError) as caught:
        deck(kind, *overrides, **changes)
    return {complaint.key: complaint.problem for complaint in caught.value.complaints}


def test_scaled_numbers_by_hand():
    """L_x/d = 100, 1 - r^2 = 0.19, A omega = 0.1 pi m/s: T_* = 0.0987 m^2/s^2."""
    found = deck()
    gas, loss, strength = found.gas, found.gas.L, found.wall.W
    assert loss == pytest.approx(32.0 / (3.0 * 2.26) * 1e4 * 0.19, rel=1e-13)
    assert gas.f == pytest.approx(1000 * math.sqrt(3.0) * 4e-6 / (2.0 * 0.06), rel=1e-13)
    assert (gas.K, gas.mu) == (pytest.approx(0.02, rel=1e-13), 2.0)
    assert found.box.aspect_ratio == pytest.approx(1.5, rel=1e-13)
    assert strength == pytest.approx(0.7978845608028654 / 0.02, rel=1e-13)
    assert gas.tau == pytest.approx(1.5957691216057308 * 0.01 * math.pi**2 / (1e-3 * 10.0 * 0.2), rel=1e-13)
    assert found.experiment.temperature == pytest.approx(0.01 * math.pi**2, rel=1e-13)
    assert found.experiment.time == pytest.approx(0.2 / (0.1 * math.pi), rel=1e-13)
    assert found.experiment.density == pytest.approx(2.0 / (math.sqrt(3.0) * 4e-6), rel=1e-13)
    assert found.scaled.amplitude == pytest.approx(0.005, rel=1e-13)
    assert found.scaled.frequency == pytest.approx(100.0 * math.pi * 0.2 / (0.1 * math.pi), rel=1e-13)


def test_the_unit_of_temperature_changes_no_physics():
    """Four times T_*: velocities in units of it are half as large, the unit of time is half as long."""
    base, other = deck(), deck(temperature_scale=f"{0.04 * math.pi**2!r} m^2/s^2")
    strengths = [one.wall.W for one in (base, other)]
    assert strengths[1] == pytest.approx(0.25 * strengths[0], rel=1e-12)
    assert other.experiment.time == pytest.approx(0.5 * base.experiment.time, rel=1e-12)
    assert (other.gas.L, other.gas.f, other.gas.K) == (base.gas.L, base.gas.f, base.gas.K)
    tau = [one.gas.tau * one.experiment.time for one in (base, other)]
    assert tau[0] == pytest.approx(tau[1], rel=1e-12)
    here = [stripe_of(one, Place(one.gas.L, one.gas.f, 1.0)) for one in (base, other)]
    for assumption in ASSUMPTIONS:
        ratio, same = map(assumption.ratio, here)
        assert ratio == pytest.approx(same, rel=1e-12)


def test_covered_area_and_area_fraction():
    """phi of disks at close packing is pi/(2 3^(1/2)) where f = 1."""
    by_f = deck(N=None, f=0.03)
    by_phi = deck(N=None, phi=0.03 * 0.9068996821171089)
    assert by_phi.gas.f == pytest.approx(by_f.gas.f, rel=1e-13) and by_f.gas.f == 0.03
    area = 1000 * math.pi * 1e-3**2 / 0.06
    assert deck(N=None, phi=area).gas.f == pytest.approx(deck().gas.f, rel=1e-13)


def test_frequency_and_angular_frequency():
    for omega in (f"{100.0 * math.pi!r} rad/s", "3000 rpm", "18000 deg/s"):
        assert deck(frequency=None, omega=omega).scaled == pytest.approx(deck().scaled, rel=1e-12)


LENGTHS = {"nm": 1e-9, "um": 1e-6, "µm": 1e-6, "mm": 1e-3, "cm": 1e-2, "m": 1.0, "km": 1e3, "inch": 0.0254}
FREQUENCIES = {"mHz": 1e-3, "Hz": 1.0, "kHz": 1e3, "s^-1": 1.0, "ms^-1": 1e3}


@settings(max_examples=60, deadline=None)
@given(
    st.tuples(*[st.sampled_from(sorted(LENGTHS))] * 4),
    st.sampled_from(sorted(FREQUENCIES)),
    st.sampled_from(["m/s^2", "m s^-2", "m/s**2", "cm/s²", "km/s^2"]),
)
def test_other_units_give_the_same_scaled_numbers(lengths, frequency, acceleration):
    values = dict(zip(("d", "L_x", "L_y", "A"), (2e-3, 0.2, 0.3, 1e-3), strict=True))
    changes = {
        key: f"{value / LENGTHS[unit]!r} {unit}" for (key, value), unit in zip(values.items(), lengths, strict=True)
    }
    scale = {"cm/s²": 1e-2, "km/s^2": 1e3}.get(acceleration, 1.0)
    changes |= {
        "frequency": f"{50.0 / FREQUENCIES[frequency]!r} {frequency}",
        "gravity": f"{10.0 / scale!r} {acceleration}",
    }
    assert deck(**changes).scaled == pytest.approx(deck().scaled, rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "key", "problem"),
    [
        ({"d": 2}, "experiment.d", '2 is not allowed; must be a length with its unit, such as "1 mm"'),
        ({"d": "2"}, "experiment.d", 'must be a length with its unit, such as "1 mm"'),
        ({"d": "2 s"}, "experiment.d", "its unit is that of second; must be a length"),
        ({"d": "2 m^2"}, "experiment.d", "its unit is that of meter ** 2; must be a length"),
        ({"d": "2 mn"}, "experiment.d", "'mn' is not defined"),
        ({"d": "two mm"}, "experiment.d", "must be a length"),
        ({"d": "-2 mm"}, "experiment.d", "must be positive"),
        ({"d": "0 mm"}, "experiment.d", "must be positive"),
        ({"d": "1e400 mm"}, "experiment.d", "from 1e-12 to 1e+12"),
        ({"d": "9**9**9 m"}, "experiment.d", "must be a length"),
        ({"d": "2 m**99999999"}, "experiment.d", "must be a length"),
        ({"d": "__import__('os')"}, "experiment.d", "must be a length"),
        ({"d": None}, "experiment.d", "required: diameter of the grains"),
        ({"A": True}, "experiment.A", "true is not allowed; must be a length"),
        ({"L_x": "1 mm"}, "experiment.L_x", "must be longer than a grain, 2 mm"),
        ({"N": 10**5}, "experiment.N", "so many grains do not fit into the box: n/n_c would be 5.774"),
        ({"N": 0}, "experiment.N", "must be at least 1"),
        ({"N": None}, "experiment.N", "exactly one of N, f and phi"),
        ({"f": 0.1}, "experiment.N", "exactly one of N, f and phi"),
        ({"N": None, "phi": 0.91}, "experiment.phi", "must be less than 0.9069"),
        ({"r": 1.01}, "experiment.r", "must be at most 1"),
        ({"r": "0.9"}, "experiment.r", "must be a number"),
        ({"mu": 0.0}, "experiment.mu", "must be at least 0.01"),
        ({"rolling_friction": -1e-3}, "experiment.rolling_friction", "must be at least 0"),
        ({"frequency": 50}, "experiment.frequency", 'must be a frequency with its unit, such as "50 Hz"'),
        ({"frequency": "314 rad/s"}, "experiment.frequency", "that of radian / second; must be a frequency"),
        ({"frequency": "3000 rpm"}, "experiment.frequency", "must be a frequency"),
        ({"frequency": None}, "experiment.frequency", "exactly one of frequency and omega"),
        ({"omega": "314 rad/s"}, "experiment.frequency", "exactly one of frequency and omega"),
        ({"frequency": None, "omega": "50 Hz"}, "experiment.omega", 'must be an angular frequency with its unit'),
        ({"gravity": "9.81 m/s"}, "experiment.gravity", "must be an acceleration"),
        ({"temperature_scale": "300 K"}, "experiment.temperature_scale", "must be an energy per mass"),
        ({"diameter": "1 mm"}, "experiment.diameter", "unknown key; known: d, L_x"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("kind", ["evolution", "stability"])
def test_what_is_no_experiment_is_refused(kind, changes, key, problem):
    found = complaints(kind=kind, **changes)
    assert list(found) == [key] and problem in found[key]


@pytest.mark.parametrize(
    ("kind", "key", "value"),
    [
        *[(kind, key, "0.5") for kind in ("evolution", "steady", "branch")
          for key in ("gas.L", "gas.f", "gas.K", "gas.tau", "gas.mu", "box.aspect_ratio", "wall.W")],
        ("stability", "stability.L", "[1e4]"),
        ("stability", "stability.points", "[]"),
    ],
)  # fmt: skip
def test_scaled_numbers_beside_an_experiment_are_refused_by_name(kind, key, value):
    found = complaints(f"{key}={value}", kind=kind)
    assert list(found) == [key] and "beside [experiment], from which it follows" in found[key]


def test_complaints_about_what_follows_name_the_experiment():
    elastic = complaints(kind="steady", r=1.0)
    assert elastic == {"experiment": "gas.L follows from it: 0.0 is not allowed; must be greater than 0"}
    dense = complaints("initial.amplitude=0.99", N=None, f=0.6)
    assert list(dense) == ["experiment"] and "gas.f follows from it: 0.6 is not allowed" in dense["experiment"]


def test_all_complaints_at_once():
    found = complaints("mesh.cells=[1, 8]", "gas.K=1", "gas.gamma=-1", "time.end=0", d="2", r=3.0)
    assert set(found) == {"mesh.cells[0]", "gas.K", "gas.gamma", "time.end", "experiment.d", "experiment.r"}


def test_a_wall_without_vibration_needs_no_strength():
    assert not hasattr(deck("evolution", "wall.kind=thermal").wall, "W")
    assert not hasattr(deck("evolution", "wall.kind=elastic").wall, "W")
    assert list(complaints("wall.kind=thermal", "wall.W=1")) == ["wall.W"]


def test_gamma_of_the_closure_counts():
    usual, half = (deck("evolution", f"gas.gamma={gamma}").gas.L for gamma in (2.26, 1.13))
    assert half == pytest.approx(2.0 * usual, rel=1e-13)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("changes", [{}, {"N": None, "phi": 0.1, "rolling_friction": 0.0}])
def test_round_trip(kind, changes):
    first = deck(kind, **changes)
    text = dumps(first)
    assert parse(text) == first
    assert 'd = "2 mm"' in text and "\nL = " not in text
    (loss,) = (line for line in text.splitlines() if line.startswith(("# gas.L = ", "# stability.L = ")))
    assert float(loss.partition(" = ")[2].strip("[]")) == first.scaled.L


def test_a_thermal_wall_goes_the_round_trip_too():
    first = deck("evolution", "wall.kind=thermal", "wall.temperature=2")
    assert parse(dumps(first)) == first and "wall.W" not in dumps(first)


def test_the_run_folder_keeps_the_experiment(tmp_path):
    small = ["mesh.cells=[8,8]", "time.end=0.01", "output.times=[]"]
    assert main([str(PROBLEMS / "experiment.toml"), *small, "--output", str(tmp_path / "run"), "--quiet"]) == 0
    text = (tmp_path / "run" / "deck.toml").read_text(encoding="utf-8")
    assert 'A = "1.5 mm"' in text and "# gas.L = 11157.5" in text and "# time L_x/T_*^(1/2) = 0.707355 s" in text
    assert load(tmp_path / "run" / "deck.toml") == load(PROBLEMS / "experiment.toml", small)


def table(*overrides, **changes):
    """The extended state and the grains of the table."""
    found = deck("evolution", *overrides, **changes)
    return stripe_of(found, Place(found.gas.L, found.gas.f, found.box.aspect_ratio))


def ratio_of(name, stripe):
    (found,) = (assumption.ratio(stripe) for assumption in ASSUMPTIONS if assumption.name == name)
    return found


def test_ratios_by_hand():
    """From profiles of n and T on a fine grid, in physical units: d = 2 mm, L_x = 20 cm, A omega = 0.1 pi m/s."""
    stripe, found = table(), deck()
    x = np.linspace(0.0, 1.0, 20001)
    n, wall = stripe.state.density_at(x), stripe.grains.wall
    T = stripe.state.temperature_at(x, wall) * 0.01 * math.pi**2
    path = 2e-3 * math.sqrt(3.0 / 32.0) * (1.0 - n) / (n * (1.0 - (1.0 - math.sqrt(0.375)) * n))
    collisions = np.trapezoid(2.0 / 2.26 * (1.0 - 0.81) * n * T**1.5 / path, x)
    tau = math.sqrt(8.0 / math.pi) * 0.1 * math.pi / (1e-3 * 10.0)
    assert ratio_of("nearly elastic grains", stripe) == pytest.approx(0.19, rel=1e-12)
    assert ratio_of("small amplitude", stripe) == pytest.approx(1e-3 / path[-1], rel=1e-9)
    assert ratio_of("fast vibration", stripe) == pytest.approx(T[-1] ** 0.5 / path[-1] / (100.0 * math.pi), rel=1e-9)
    assert ratio_of("slow wall", stripe) == pytest.approx(0.1 * math.pi / T[-1] ** 0.5, rel=1e-9)
    assert ratio_of("dilute at the driving wall", stripe) == pytest.approx(n[-1], rel=1e-9)
    assert ratio_of("weak friction", stripe) == pytest.approx(np.trapezoid(2.0 * n * T / tau, x) / collisions, rel=1e-5)
    rolling = np.trapezoid(n * 1e-3 * 10.0 * np.sqrt(0.5 * math.pi * T), x)
    assert ratio_of("weak rolling friction", stripe) == pytest.approx(rolling / collisions, rel=1e-5)
    slope = (3.0 * T[-1] - 4.0 * T[-2] + T[-3]) / (2.0 * 0.2 * (x[1] - x[0]))
    assert ratio_of("no temperature jump", stripe) == pytest.approx(path[-1] * slope / T[-1], rel=1e-5)
    assert ratio_of("fluid cluster", stripe) == pytest.approx(n[0], rel=1e-9)
    heat = math.sqrt(2.0 / math.pi) * (0.1 * math.pi) ** 2 * n[-1] * T[-1] ** 0.5  # per area and n_c, from the wall
    assert collisions * 0.2 == pytest.approx(heat, rel=1e-5)
    assert found.scaled is not None


def test_what_is_not_known_is_not_judged():
    scaled = load(PROBLEMS / "fig4.toml")
    stripe = stripe_of(scaled, Place(5e4, 0.0235, 2.0))
    unknown = {assumption.name for assumption in ASSUMPTIONS if assumption.ratio(stripe) is None}
    assert unknown == {"small amplitude", "fast vibration", "weak rolling friction"}
    thermal = table("wall.kind=thermal")
    unknown = {assumption.name for assumption in ASSUMPTIONS if assumption.ratio(thermal) is None}
    assert unknown == {"small amplitude", "fast vibration", "slow wall"}


@pytest.mark.parametrize("assumption", ASSUMPTIONS, ids=lambda assumption: assumption.name)
def test_verdicts_change_at_the_stated_ratios(assumption):
    assert assumption.limits == (FLUID if assumption.name == "fluid cluster" else SMALL)
    good, violated = assumption.limits
    for limit, before, after in ((good, "good", "marginal"), (violated, "marginal", "violated")):
        assert assumption.verdict(np.nextafter(limit, 0.0)) == before and assumption.verdict(limit) == after
        assert f"good below {good:g}, violated from {violated:g}" in assumption.row(limit)
        assert bool(assumption.warnings(limit)) == (after == "violated")
    assert assumption.verdict(math.nan) == "violated"


@pytest.mark.parametrize(("limit", "before", "after"), [(0.1, "good", "marginal"), (0.3, "marginal", "violated")])
def test_verdicts_change_with_the_experiment(limit, before, after):
    """1 - r^2 by r; A/l by A, since neither n nor, in units of A^2 omega^2, T depends on A; friction by its own law."""
    amplitude = limit / ratio_of("small amplitude", table()) * 1e-3
    friction = limit / ratio_of("weak rolling friction", table()) * 1e-3
    for name, key, at, grows in (
        ("nearly elastic grains", "r", math.sqrt(1.0 - limit), False),
        ("small amplitude", "A", amplitude, True),
        ("weak rolling friction", "rolling_friction", friction, True),
    ):
        for below, verdict in ((True, before), (False, after)):
            value = float(at) * (1.0 + (-1e-9 if below == grows else 1e-9))
            stripe = table(**{key: f"{value!r} m" if key == "A" else value})
            (row,) = (one.row(one.ratio(stripe)) for one in ASSUMPTIONS if one.name == name)
            assert f" {verdict} " in row


def test_friction_time_is_that_of_a_slow_flow_of_maxwellian_grains():
    """The mean of -mu_r g c/|c| over grains whose mean velocity is V, by quadrature, against -V/tau for V -> 0."""
    T, braking, V = 0.01 * math.pi**2, 1e-3 * 10.0, 1e-4
    angle = 2.0 * math.pi * (np.arange(256) + 0.5) / 256
    speed, weight = np.polynomial.legendre.leggauss(400)
    speed = 0.5 * (speed + 1.0) * 12.0 * T**0.5
    weight = 0.5 * weight * 12.0 * T**0.5 * speed * 256**-1 / T
    u = speed[:, None] * np.cos(angle)
    shifted = np.exp(-(speed[:, None] ** 2 - 2.0 * V * u + V**2) / (2.0 * T))
    drag = braking * np.sum(weight[:, None] * shifted * np.cos(angle))
    found = deck().experiment
    tau = deck().gas.tau * found.time
    assert V / drag == pytest.approx(tau, rel=1e-6)
    loss = braking * np.sum(weight * speed * np.exp(-(speed**2) / (2.0 * T)) * 256)
    assert loss == pytest.approx(2.0 * T / tau, rel=1e-9)  # the same tau gives the loss of random motion


def test_heat_of_a_wall_that_is_not_slow():
    """The heat is 1 + A^2 omega^2/(8 T) times that of a slow wall: quadrature over phases and velocities at T = 1."""
    for speed in (0.1, 0.3):
        U = speed * np.sin(2.0 * math.pi * (np.arange(64) + 0.5) / 64)[:, None]
        w, weight = np.polynomial.legendre.leggauss(200)
        w, weight = 6.0 * (w + 1.0), 6.0 * weight  # velocity of a grain against the wall
        f = np.exp(-0.5 * (w + U) ** 2) / math.sqrt(2.0 * math.pi)
        heat = np.mean(np.sum(weight * f * w * -2.0 * U * w, axis=1))
        slow = math.sqrt(2.0 / math.pi) * speed**2
        assert heat / slow - 1.0 == pytest.approx(speed**2 / 8.0, rel=0.05)


@pytest.mark.parametrize("wall", ["vibrating", "thermal"])
@pytest.mark.parametrize("periodic", [False, True])
def test_position_changes_at_the_critical_aspect_ratio(wall, periodic):
    state = table(r=0.97, d="1 mm", N=3000).state
    critical = critical_aspect_ratio(state, wall, 2 if periodic else 1).aspect_ratio
    for factor, where in ((1.0 - 1e-9, "outside the tongue, the extended state is stable"), (1.0 + 1e-9, "inside")):
        assert where in position(state, Place(1.0, 0.5, critical * factor), wall, periodic)


def check(capsys, *words):
    assert main(["check", *map(str, words)]) == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("name", ["branches", "coarsening", "fig3a", "fig4", "experiment", "experiment_stable", "fig2"])
def test_check_says_where_a_deck_lies(name, capsys):
    printed = check(capsys, PROBLEMS / f"{name}.toml")
    assert "the tongue, the extended state is" in printed
    assert ("nearly elastic grains" in printed) == (name != "fig2")  # its grains are not known


def test_check_of_a_stability_deck_judges_the_experiment(tmp_path, capsys):
    section = "\n".join(f"{key} = {json.dumps(value)}" for key, value in TABLE.items())
    (tmp_path / "curve.toml").write_text(f'kind = "stability"\n{STABILITY}\n[experiment]\n{section}\n')
    printed = check(capsys, tmp_path / "curve.toml")
    assert 'label = "experiment"' in printed and "small amplitude" in printed and "vibrating wall" in printed


def test_check_of_an_undriven_box_says_so(capsys):
    printed = check(capsys, PROBLEMS / "cooling.toml", "gas.mu=0.1")
    assert "no extended state" in printed and "warning: 1 - r^2 = 4.24" in printed


def test_check_of_extreme_decks_ends_well(capsys):
    words = ("gas.L=1e30", "gas.f=1e-30"), ("gas.K=1e30", "gas.f=0.999999"), ("wall.W=1e-30", "gas.alpha=1e30")
    for overrides in words:
        assert "L = " in check(capsys, PROBLEMS / "fig3a.toml", *overrides)


# The two decks


def half_wave(name, tmp_path, cells):
    """Growth rate of the half-wave on the extended state of a deck, and the checkpoint of the two together."""
    data = tomllib.loads((PROBLEMS / f"{name}.toml").read_text(encoding="utf-8"))
    section = "\n".join(f"{key} = {json.dumps(value)}" for key, value in data["experiment"].items())
    (tmp_path / "rest.toml").write_text(
        f'kind = "steady"\nmesh = {{ cells = {cells} }}\nsteady = {{ wave = 0, mode_amplitude = 0.01 }}\n'
        f"[experiment]\n{section}\n"
    )
    assert main([str(tmp_path / "rest.toml"), "--output", str(tmp_path / "rest"), "--quiet"]) == 0
    (sector,) = (one for one in summary_of(tmp_path / "rest")["sectors"] if one["sector"] == "1 half-wave")
    return sector["growth_rates"][0], tmp_path / "rest" / "checkpoints" / "steady_plus_1_half-wave.h5"


def contrast(folder):
    """Times, and wall maximum over minimum then."""
    with (folder / "history.csv").open() as file:
        rows = [(float(row["time"]), float(row["wall_max"]) / float(row["wall_min"])) for row in csv.DictReader(file)]
    return np.array(rows).T


@pytest.mark.parametrize(("name", "cells"), [("experiment", [16, 32]), ("experiment_stable", [16, 16])])
def test_the_half_wave_grows_inside_the_tongue_and_decays_outside(name, cells, tmp_path, run_deck):
    """The steady solver's growth rate against the evolution from the same state, to 3%."""
    rate, start = half_wave(name, tmp_path, cells)
    assert (rate > 0.0) == (name == "experiment")
    words = (f"mesh.cells={cells}", "initial.kind=checkpoint", f"initial.path={start}", "output.times=[]")
    folder, code = run_deck(name, *words, "time.end=20", "output.history_every=1")
    assert code == 0
    times, ratios = contrast(folder)
    slope = np.polyfit(times, np.log(np.log(ratios)), 1)[0]
    assert slope == pytest.approx(rate, rel=0.03)


@pytest.mark.parametrize(("name", "cells"), [("experiment", [16, 32]), ("experiment_stable", [16, 16])])
def test_a_cosine_becomes_a_cluster_or_nothing(name, cells, run_deck):
    folder, code = run_deck(name, f"mesh.cells={cells}")
    assert code == 0
    _, ratios = contrast(folder)
    assert ratios[-1] > 5.0 if name == "experiment" else ratios[-1] < 1.01
