"""Studies: their decks, convergence with orders and limits, sweeps on processes and on a cluster."""

from __future__ import annotations

import csv
import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import numba
import numpy as np
import pytest
from conftest import summary_of

import hydro
from hydro.choices import INITIAL_STATES
from hydro.cli import main
from hydro.deck import changed, dumps, load, parse
from hydro.deck.sections import Range
from hydro.dynamics import Godunov
from hydro.errors import DeckError, NotInstalled, StepRejected
from hydro.gas import Grossman
from hydro.initial import initial_state
from hydro.initial.checkpoint import refilled
from hydro.mesh import Mesh
from hydro.output.checkpoint import Checkpoint, read_checkpoint
from hydro.setup import integrator_of, mesh_of
from hydro.state import State
from hydro.studies.cluster import work
from hydro.studies.orders import order_of_values, orders, richardson
from hydro.studies.references import averages
from hydro.studies.sweep import open_sweep
from hydro.studies.table import write_table

BASE = """
[base]
kind = "evolution"
gas = { L = 5e4, f = 0.0235, K = 2e-3, tau = 200.0 }
mesh = { cells = [8, 8] }
initial = { kind = "cosine", amplitude = 0.1 }
time = { end = 0.2, integrator = "lagrange-remap" }
output = { times = [0.1, 0.2], pictures = false }
"""
CONVERGENCE = f"""
kind = "convergence"
{BASE}
[convergence]
scalars = ["wall_max"]
ladder = {{ keys = ["mesh.cells"], values = [[8, 8], [16, 16], [32, 32]] }}
"""
SWEEP = f"""
kind = "sweep"
{BASE}
[sweep]
axes = [
    {{ keys = ["gas.f"], values = {{ start = 0.02, stop = 0.03, count = 3 }} }},
    {{ keys = ["box.aspect_ratio", "mesh.cells"], values = [[1.0, [8, 8]], [2.0, [8, 16]]] }},
]
"""


@pytest.fixture
def run_text(tmp_path):
    """Runs a deck given as text by the command line in a temporary folder: (folder, exit code)."""

    def run(text: str, *words: str, folder: str = "run"):
        (tmp_path / "deck.toml").write_text(text)
        return tmp_path / folder, main(
            [str(tmp_path / "deck.toml"), "--output", str(tmp_path / folder), "--quiet", *words]
        )  # fmt: skip

    return run


def rows_of(folder: Path) -> list[dict[str, str]]:
    """The rows of a study's table."""
    with (folder / "table.csv").open() as file:
        return list(csv.DictReader(file))


# Decks


def test_a_base_deck_may_be_a_file_that_other_keys_change(tmp_path):
    (tmp_path / "inner").mkdir()
    inner = parse(CONVERGENCE).base
    (tmp_path / "inner" / "base.toml").write_text(dumps(inner))
    for base, expected in (
        ('base = "inner/base.toml"', inner),
        ('[base]\ndeck = "inner/base.toml"\ntime.end = 3.0', changed(inner, {"time.end": 3.0})),
        (
            '[base]\ndeck = "inner/base.toml"\ninitial = { kind = "noise" }',
            changed(inner, {"initial.kind": "noise"}),
        ),
    ):
        (tmp_path / "outer.toml").write_text(SWEEP.replace(BASE, base + "\n"))
        deck = load(tmp_path / "outer.toml", ["base.gas.K=1e-3"])
        assert deck.base == changed(expected, {"gas.K": 1e-3})
        assert parse(dumps(deck)) == deck


def test_axes_are_multiplied_and_keys_of_one_axis_go_together():
    changes = parse(SWEEP).changes
    assert [row["gas.f"] for row in changes] == [0.02, 0.02, 0.025, 0.025, 0.03, 0.03]
    assert [(row["box.aspect_ratio"], row["mesh.cells"]) for row in changes[:2]] == [(1.0, [8, 8]), (2.0, [8, 16])]


def test_ranges():
    assert Range(start=0.005, stop=0.065, count=13).values[:3] == (0.005, 0.01, 0.015)
    assert Range(start=3.0, stop=1.0, count=3).values == (3.0, 2.0, 1.0)
    assert Range(start=1e-3, stop=10.0, count=5, spacing="log").values == pytest.approx((1e-3, 1e-2, 0.1, 1.0, 10.0))


@pytest.mark.parametrize(
    ("text", "override", "key", "problem"),
    [
        (SWEEP, "base.gas.f=1.5", "base.gas.f", "must be less than 1"),
        (SWEEP, "base.wall.kind=odd", "base.wall.kind", "known: vibrating, thermal, elastic"),
        (SWEEP, "base.box.periodic=['x']", "base.wall.kind", "must be 'elastic'"),
        (SWEEP, "base=3", "base", "must be a section"),
        (SWEEP, "base.kind=sweep", "base.kind", "known: evolution, steady, branch, stability, grains, convergence"),
        (CONVERGENCE, "base.kind=branch", "base.kind", "known: evolution, steady"),
        (SWEEP, "sweep.axes=[]", "sweep.axes", "must have 1 items or more"),
        (SWEEP, "sweep.axes=[{keys=['gas.f'], values=[]}]", "sweep.axes[0].values", "must have an item"),
        (SWEEP, "sweep.axes=[{keys=['gas.f', 'gas.f'], values=[[1, 2]]}]", "sweep.axes[0].keys", "not repeat"),
        (SWEEP, "sweep.axes=[{keys=['gas.f', 'gas.K'], values=[1]}]", "sweep.axes[0].values", "lists of 2 values"),
        (SWEEP, "sweep.axes=[{keys=['gas.ff'], values=[1]}]", "gas.ff", "unknown key"),
        (SWEEP, "sweep.axes=[{keys=['gas.f'], values=[0.1, 2]}]", "gas.f", "less than 1, in member 2: gas.f = 2"),
        (SWEEP, "sweep.axes=[{keys=['gas.f'], values=[[1]]}]", "gas.f", "must be a number, in member 1"),
        (
            SWEEP,
            "sweep.axes=[{keys=['gas.f'], values={start=0, stop=1, count=3, spacing='log'}}]",
            "sweep.axes[0].values.spacing",
            "must be greater than 0",
        ),
        (
            SWEEP,
            "sweep.axes=[{keys=['gas.f'], values=[0.1]}, {keys=['gas.f'], values=[0.2]}]",
            "sweep.axes",
            "must not change the same key",
        ),
        (
            SWEEP,
            "sweep.axes=[{keys=['gas.f'], values={start=0, stop=1, count=100000}}, {keys=['gas.K'], values=[1, 2]}]",
            "sweep.axes",
            "100000 combinations or less",
        ),
        (SWEEP, "sweep.draw=['wall_mx']", "sweep.draw", "did you mean 'wall_max'?"),
        (SWEEP, "sweep.perturbation={kind='noise'}", "sweep.perturbation", "set sweep.chain"),
        (CONVERGENCE, "convergence.scalars=['growth_rate']", "convergence.scalars", "known for kind 'evolution'"),
        (CONVERGENCE, "convergence.reference=exat", "convergence.reference", "known: exact, finest, next"),
        (CONVERGENCE, "convergence.reference=exact", "base.initial.kind", "must have an exact evolution"),
        (CONVERGENCE, "convergence.ladder.values=[[8, 8]]", "convergence.ladder", "two levels or more"),
        (CONVERGENCE, "convergence.ladder.values=[[8, 8], [8, 8]]", "convergence.ladder", "from coarse to fine"),
        (CONVERGENCE, "convergence.ladder={keys=['gas.f'], values=[1, 2]}", "convergence.ladder", "one of mesh.cells"),
        (CONVERGENCE, "convergence.ladder.values=[[8, 2], [16, 4]]", "mesh.cells[1]", "at least 4, in member 1"),
        (CONVERGENCE, "convergence.ladder.values=[8, 16]", "mesh.cells", "must be a list, in member 2"),
        (CONVERGENCE, "expect.order=0", "expect.order", "must be greater than 0"),
    ],
)  # fmt: skip
def test_one_complaint(text, override, key, problem):
    with pytest.raises(DeckError) as caught:
        parse(text, [override])
    found = {complaint.key: str(complaint) for complaint in caught.value.complaints}
    assert key in found and problem in found[key]


EXACT = [kind for kind in INITIAL_STATES if INITIAL_STATES[kind].exact_if is not None]


@pytest.mark.parametrize("kind", EXACT)
def test_what_an_exact_evolution_needs_is_asked_for(kind):
    """Each rule, broken alone, is named; with all of them kept the deck is valid."""
    words = {
        "gas.K": ("gas.K=0.0", "gas.K=1.0"),
        "gas.L": ("gas.L=0.0", "gas.L=1.0"),
        "gas.tau": ("gas.tau=inf", "gas.tau=1.0"),
        "box.periodic": ("box.periodic=['x']", "box.periodic=[]"),
        "wall.kind": ("wall.kind=elastic", "wall.kind=thermal"),
        "initial.velocity": ("initial.velocity=[0, 0]", "initial.velocity=[1, 0]"),
    }
    needed = {rule.key: words[rule.key] for rule in INITIAL_STATES[kind].exact_if}
    if kind == "manufactured":
        needed["box.periodic"] = needed["box.periodic"][::-1]
    common = [f"base.initial={{kind='{kind}'}}", "convergence.reference=exact", "base.wall.kind=elastic"]
    kept = [f"base.{right}" for right, _ in needed.values()]
    assert parse(CONVERGENCE, [*common, *kept]).base.initial.kind == kind
    for key, (_, wrong) in needed.items():
        with pytest.raises(DeckError, match=f"{key} must|must be 'elastic'"):
            parse(CONVERGENCE, [*common, *kept, f"base.{wrong}"])


def test_a_base_deck_that_is_not_there(tmp_path, capsys):
    (tmp_path / "deck.toml").write_text(SWEEP.replace(BASE, 'base = "nowhere.toml"\n'))
    assert main(["check", str(tmp_path / "deck.toml")]) == 2
    assert "nowhere.toml: cannot be read" in capsys.readouterr().err


def test_check_says_what_will_be_run(tmp_path, capsys):
    for text, lines in (
        (SWEEP, ["# gas.f: 3 values", "# box.aspect_ratio, mesh.cells: 2 values", "# 6 members"]),
        (
            CONVERGENCE,
            ["# mesh.cells = [8, 8]", "# the last of these 3 runs:", "# narrowest cell in x          0.03125"],
        ),
    ):
        (tmp_path / "deck.toml").write_text(text)
        assert main(["check", str(tmp_path / "deck.toml")]) == 0
        printed = capsys.readouterr().out
        assert all(line in printed for line in lines)


# Exact evolutions as initial states, sources, refilling


def evolution(*overrides: str):
    """An evolution deck."""
    return parse(dumps(parse(CONVERGENCE).base), overrides)


@pytest.mark.parametrize("kind", EXACT)
def test_an_exact_evolution_starts_from_its_initial_state(kind):
    deck = evolution(f"initial={{kind='{kind}'}}", "wall.kind=elastic", "box.periodic=['y']")
    start = initial_state(deck)
    np.testing.assert_array_equal(start.conserved, deck.initial.evolution(deck)(mesh_of(deck), 0.0))
    if kind != "manufactured":
        assert start.mass == pytest.approx(deck.gas.f * deck.box.aspect_ratio, rel=1e-12)


@pytest.mark.parametrize("integrator", ["godunov", "lagrange-remap"])
def test_what_a_source_gives_is_in_the_books(integrator):
    words = ("initial={kind='manufactured'}", "gas.L=200", "gas.K=0.05", "gas.tau=2", "wall.W=3", "time.tolerance=1e6")
    deck = evolution(*words, f"time.integrator={integrator}")
    state = initial_state(deck)
    start, stepper = state.energy, integrator_of(deck, state)
    booked = [list(stepper.step(state, 1e-3).values()) for _ in range(5)]
    wall, lost, rubbed, source, _ = np.sum(booked, axis=0)
    assert abs(source) > 1e-5
    assert state.energy - start == pytest.approx(wall - lost - rubbed + source, abs=1e-14)


def test_refilling_keeps_bounds_temperature_and_uniform_pressure():
    gas, mesh = Grossman(5e4, 2e-3), Mesh.rectangle((16, 16))
    n = np.geomspace(0.003, 0.99, 256).reshape(16, 16)
    state = State.of(gas, mesh, n, gas.temperature(n, 1.0), (0.1, 0.0))
    for mean in (0.5 * state.mass, 0.999):
        filled = refilled(state, mean)
        assert filled.mass == pytest.approx(mean, rel=1e-12) and np.all(filled.density < 1.0)
        np.testing.assert_allclose(filled.temperature, state.temperature, rtol=1e-10)
        np.testing.assert_allclose(filled.velocity[0], 0.1, rtol=1e-12)
    factor = refilled(state, 1.02 * state.mass).pressure
    assert factor.max() / factor.min() < 1.05
    np.testing.assert_allclose(refilled(state, state.mass).density, n, rtol=1e-10)


# Orders and limits


def test_orders_of_values():
    sizes = (1.0, 0.6, 0.2)
    for p in (0.7, 2.0, 3.3):
        assert order_of_values(sizes, [4.0 - 2.0 * size**p for size in sizes]) == pytest.approx(p, rel=1e-10)
    assert order_of_values((4, 2, 1), (1.0, 2.0, 1.0)) is None
    assert order_of_values((4, 2, 1), (1.0, 2.0, 4.0)) is None
    assert order_of_values((4, 2, 1), (1.0, 2.0, 2.0)) is None


def test_limits_and_their_error_bars():
    sizes = (1.0, 0.5, 0.25, 0.125)
    exact = richardson(sizes, [3.0 + 0.7 * size**2 for size in sizes], 2.0)
    assert exact.value == pytest.approx(3.0, abs=1e-14) and exact.error < 1e-14 and exact.order == pytest.approx(2.0)
    first_order = richardson(sizes, [3.0 + 0.7 * size for size in sizes], 2.0)
    assert abs(first_order.value - 3.0) <= first_order.error * (1.0 + 1e-9)
    assert first_order.order == pytest.approx(1.0)
    scattered = richardson(sizes, [3.0, 3.2, 3.1, 3.15], 2.0)
    assert scattered.order is None and scattered.error >= 0.1
    assert richardson((1.0, 0.5), (3.4, 3.1), 2.0) == pytest.approx((3.0, 0.1, None))


def test_averages_over_coarser_cells_keep_mass_and_stretching():
    fine, coarse = (Mesh.rectangle((n, 2 * n), 2.0, stretch=3.0) for n in (12, 4))
    fields = 0.2 + 0.3 * np.random.default_rng(0).random((4, *fine.cells))
    fields[3] += 1.0
    saved = Checkpoint.of(State(Grossman(0.0, 0.0), fine, fields), "")
    means = averages(saved, coarse)
    for mean, field in zip(means, fields, strict=True):
        assert coarse.integral(mean) == pytest.approx(fine.integral(field), rel=1e-13)
    assert means[0, 1, 2] == pytest.approx(np.average(fields[0, 3:6, 6:9], weights=fine.areas[3:6, 6:9]))


# Convergence


def test_convergence_measures_orders_and_limits(run_text):
    folder, code = run_text(CONVERGENCE)
    summary = summary_of(folder)
    rows = summary["rows"]
    assert code == 0 and summary["completed"] and [row["cells"] for row in rows] == [[8, 8], [16, 16], [32, 32]]
    assert rows[0]["orders"]["total"] is None and rows[2]["errors"]["total"] is None
    totals = [row["errors"]["total"] for row in rows[:2]]
    assert rows[1]["orders"]["total"] == pytest.approx(orders([1.0, 0.5], totals)[0])
    assert totals[0] == pytest.approx(sum(value for name, value in rows[0]["errors"].items() if name != "total"))
    assert all(row["dt"] > 0.0 for row in rows)
    (limit,) = summary["limits"]
    values = [row["scalars"]["wall_max"] for row in rows]
    assert (limit["limit"], limit["error"]) == pytest.approx(richardson([4, 2, 1], values, 2.0)[:2])
    assert len(rows_of(folder)) == 3 and (folder / "pictures" / "convergence.png").exists()
    saved = [read_checkpoint(sorted((folder / row["folder"]).glob("checkpoints/*.h5"))[-1]) for row in rows[:2]]
    difference = np.abs(saved[0].conserved - averages(saved[1], saved[0].mesh))
    assert rows[0]["errors"]["density"] == pytest.approx(saved[0].mesh.integral(difference[0]))


def test_finest_as_reference(run_text):
    folder, _ = run_text(CONVERGENCE, "convergence.reference=finest")
    rows = summary_of(folder)["rows"]
    saved = [read_checkpoint(sorted((folder / row["folder"]).glob("checkpoints/*.h5"))[-1]) for row in rows]
    difference = np.abs(saved[0].conserved - averages(saved[2], saved[0].mesh))
    assert rows[0]["errors"]["density"] == pytest.approx(saved[0].mesh.integral(difference[0]))


@pytest.mark.parametrize("expectation", ["expect.order=9", "expect.limit_error=1e-9"])
def test_a_study_that_misses_what_it_expects_ends_with_5(run_text, capsys, expectation):
    folder, code = run_text(CONVERGENCE, expectation)
    assert code == 5 and summary_of(folder)["completed"] and summary_of(folder)["missed"]
    assert "is expected" in capsys.readouterr().err


def test_an_order_that_is_reached_is_no_miss(run_text):
    _, code = run_text(CONVERGENCE, "expect.order=0.5", "expect.limit_error=0.5")
    assert code == 0


def test_cells_that_do_not_lie_in_each_other_are_refused(run_text, capsys):
    folder, code = run_text(CONVERGENCE, "convergence.ladder.values=[[8, 8], [12, 12]]")
    assert code == 2 and "must be multiples of [8, 8]" in capsys.readouterr().err and not folder.exists()


def test_a_study_goes_on_where_it_was_left(run_text, capsys):
    folder, _ = run_text(CONVERGENCE)
    stamps = {path: path.stat().st_mtime_ns for path in folder.glob("members/*/summary.json")}
    (folder / "members" / "0002" / "summary.json").unlink()
    assert run_text(CONVERGENCE)[1] == 0
    again = {path for path, stamp in stamps.items() if path.stat().st_mtime_ns != stamp}
    assert again == {folder / "members" / "0002" / "summary.json"}
    deck = folder / "deck.toml"
    deck.write_text(deck.read_text().replace("mu = 1.0\n", ""))  # as an older version wrote it, without that key
    assert run_text(CONVERGENCE)[1] == 0
    assert run_text(CONVERGENCE, "base.gas.f=0.03")[1] == 2 and "holds a run already" in capsys.readouterr().err
    assert run_text(CONVERGENCE, "--overwrite")[1] == 0
    assert all(path.stat().st_mtime_ns != stamp for path, stamp in stamps.items())


def test_a_member_that_was_begun_goes_on_from_its_checkpoint(run_text):
    folder, _ = run_text(CONVERGENCE)
    first, last = sorted((folder / "members" / "0002" / "checkpoints").glob("*.h5"))
    ended, stamp = read_checkpoint(last), first.stat().st_mtime_ns
    last.unlink()
    (folder / "members" / "0002" / "summary.json").unlink()
    assert run_text(CONVERGENCE)[1] == 0
    again = read_checkpoint(last)
    assert first.stat().st_mtime_ns == stamp and again.steps == ended.steps
    np.testing.assert_array_equal(again.conserved, ended.conserved)


def test_a_level_that_fails_fails_the_study(run_text, capsys, monkeypatch):
    def no_step(self, state, dt):
        raise StepRejected("no step is any good")

    monkeypatch.setattr(Godunov, "step", no_step)
    folder, code = run_text(CONVERGENCE, "base.time.integrator=godunov")
    message = capsys.readouterr().err
    assert code == 3 and "of 3 runs are finished" in message and "Traceback" not in message
    assert summary_of(folder)["completed"] is False


# Sweeps


def test_a_sweep_makes_one_tidy_table(run_text):
    from pyarrow import parquet

    folder, code = run_text(SWEEP, "sweep.draw=['wall_max', 'half_waves']")
    summary, rows, columns = (
        summary_of(folder),
        rows_of(folder),
        parquet.read_table(folder / "table.parquet").to_pydict(),
    )
    assert code == 0 and summary["completed"] and len(summary["members"]) == len(rows) == 6
    for number, (entry, row) in enumerate(zip(summary["members"], rows, strict=True), start=1):
        assert entry["folder"] == f"members/{number:04d}" and entry["completed"] and entry["error"] is None
        assert entry["summary"] == json.loads((folder / entry["folder"] / "summary.json").read_text())
        last = entry["summary"]["snapshots"][-1]
        assert float(row["wall_max"]) == last["wall_max"] == columns["wall_max"][number - 1]
        assert json.loads(row["mesh.cells"]) == entry["overrides"]["mesh.cells"] == entry["summary"]["cells"]
        assert float(row["gas.f"]) == entry["overrides"]["gas.f"]
    table = open_sweep(folder)
    chosen = table.sel({"gas.f": 0.025, "box.aspect_ratio": 2.0})
    assert float(chosen.wall_max) == summary["members"][3]["summary"]["snapshots"][-1]["wall_max"]
    assert int(chosen.member) == 4 and str(chosen["mesh.cells"].item()) == "[8, 16]"
    assert {path.name for path in (folder / "pictures").glob("*.png")} == {"wall_max.png", "half_waves.png"}


def test_a_failed_member_is_reported_and_does_not_stop_the_rest(run_text, capsys):
    starts = "[{kind='checkpoint', path='nowhere.h5'}, {kind='uniform'}]"
    folder, code = run_text(SWEEP, f"sweep.axes=[{{keys=['initial'], values={starts}}}]")
    message = capsys.readouterr().err
    assert code == 3 and "1 of 2 members failed" in message and "nowhere.h5: no such checkpoint" in message
    failed, good = summary_of(folder)["members"]
    assert not failed["completed"] and "nowhere.h5" in failed["error"] and failed["summary"] is None
    assert good["completed"] and [row["completed"] for row in rows_of(folder)] == ["False", "True"]
    assert np.isnan(open_sweep(folder).wall_max.values).tolist() == [True, False]


def test_a_sweep_of_steady_states(run_text):
    base = '[base]\nkind = "steady"\ngas = { L = 5e4, f = 0.0235 }\nmesh = { cells = [16, 16] }\n'
    axes = "sweep.axes=[{keys=['gas.f'], values=[0.02, 0.0235]}]"
    folder, code = run_text(SWEEP.replace(BASE, base), axes)
    assert code == 0
    table = open_sweep(folder)
    assert table.stable.values.tolist() == [1.0, 1.0] and np.all(table.growth_rate < 0.0)


def test_the_expectations_of_a_convergence_member_count(run_text, capsys):
    inner = CONVERGENCE.replace('kind = "convergence"', "").replace("[base]", "[base.base]")
    inner = inner.replace("[convergence]", "[base.convergence]")
    text = f'kind = "sweep"\n[base]\nkind = "convergence"\n{inner}\n'
    axes = "sweep.axes=[{keys=['expect.order'], values=[0.1, 9.0]}]"
    folder, code = run_text(text, axes, "base.convergence.ladder.values=[[4, 4], [8, 8], [16, 16]]")
    assert code == 5 and "member 2: the order" in capsys.readouterr().err
    assert summary_of(folder)["completed"] and np.all(open_sweep(folder).order > 0.1)


CHAIN = ("sweep.chain=true", "sweep.axes=[{keys=['gas.K'], values=[2e-3, 3e-3]}, {keys=['gas.f'], values=[0.02, 0.1]}]")


def test_members_of_a_chain_start_from_the_one_before(run_text):
    folder, code = run_text(SWEEP, *CHAIN)
    decks = [load(folder / "members" / f"{number:04d}" / "deck.toml") for number in range(1, 5)]
    assert code == 0 and [deck.initial.kind for deck in decks] == ["cosine", "checkpoint"] * 2
    ends = [sorted((folder / "members" / f"{number:04d}" / "checkpoints").glob("*.h5"))[-1] for number in range(1, 5)]
    assert [Path(deck.initial.path) for deck in decks[1::2]] == ends[::2]
    for deck, end in zip(decks, ends, strict=True):
        saved = read_checkpoint(end)
        assert saved.mesh.integral(saved.conserved[0]) == pytest.approx(deck.gas.f, rel=1e-9)
    stamps = {path: path.stat().st_mtime_ns for path in folder.glob("members/*/summary.json")}
    (folder / "members" / "0004" / "summary.json").unlink()
    assert run_text(SWEEP, *CHAIN)[1] == 0
    assert {path.parent.name for path, stamp in stamps.items() if path.stat().st_mtime_ns != stamp} == {"0004"}


def test_a_chain_breaks_where_a_member_fails(run_text, capsys):
    folder, code = run_text(SWEEP, *CHAIN, "base.initial={kind='checkpoint', path='nowhere.h5'}")
    assert code == 3 and "the member that it starts from is not completed" in capsys.readouterr().err
    assert [entry["completed"] for entry in summary_of(folder)["members"]] == [False] * 4


LONG = ("base.time.dt_max=0.01", "base.time.end=30.0", "base.output.times=[30.0]", "base.mesh.cells=[16, 16]")
FOUR = "sweep.axes=[{keys=['gas.f'], values=[0.02, 0.022, 0.024, 0.026]}]"


def under_way(folder: Path) -> dict[Path, int]:
    """Folders of members that have begun and not ended, and the inode of the file that they began with."""
    begun = {path.parent: path.stat().st_ino for path in folder.glob("members/*/history.csv")}
    return {path: inode for path, inode in begun.items() if not (path / "summary.json").exists()}


def wait_until(condition, seconds: float = 180.0) -> None:
    """Wait until something is so; AssertionError if it is not after some time."""
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "it does not come"
        time.sleep(0.02)


@pytest.fixture
def cluster(tmp_path):
    """A Dask scheduler and two worker processes on this machine's loopback: (address, processes of the workers)."""
    file = tmp_path / "scheduler.json"
    common = ("--scheduler-file", str(file), "--no-dashboard")
    scheduler = start("scheduler", *common, "--host", "127.0.0.1", "--port", "0")
    wait_until(file.exists)
    workers = [start("worker", *common, "--no-nanny", "--nthreads", "1") for _ in range(2)]
    yield json.loads(file.read_text())["address"], workers
    for process in (*workers, scheduler):
        process.kill()
        process.wait()


def start(what: str, *words: str) -> subprocess.Popen:
    """A process of a cluster."""
    command = [sys.executable, "-m", "dask", what, *words]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def test_a_killed_worker_loses_no_member(cluster, tmp_path):
    """Two workers, four members; one worker is killed in the middle of a member, which the other runs anew."""
    address, workers = cluster
    (tmp_path / "deck.toml").write_text(SWEEP)
    folder = tmp_path / "run"
    words = [str(tmp_path / "deck.toml"), *LONG, FOUR, "--output", str(folder), "--quiet", "--scheduler", address]
    process = subprocess.Popen([sys.executable, "-m", "hydro", *words], stderr=subprocess.PIPE, text=True)
    wait_until(lambda: len(under_way(folder)) == 2 or process.poll() is not None)
    begun = under_way(folder)
    workers[0].kill()
    message = process.communicate(timeout=300)[1]
    assert process.returncode == 0 and len(begun) == 2, message
    assert workers[1].poll() is None
    entries = summary_of(folder)["members"]
    assert [entry["completed"] for entry in entries] == [True] * 4
    assert all(entry["summary"]["time"] == 30.0 for entry in entries)
    anew = [path for path, inode in begun.items() if (path / "history.csv").stat().st_ino != inode]
    assert len(anew) == 1


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_stops_a_sweep_that_then_goes_on(number, tmp_path):
    (tmp_path / "deck.toml").write_text(SWEEP)
    folder = tmp_path / "run"
    words = [str(tmp_path / "deck.toml"), *LONG, FOUR, "--output", str(folder), "--quiet"]
    command = [sys.executable, "-m", "hydro", *words]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    wait_until(lambda: list(folder.glob("members/*/summary.json")) or process.poll() is not None)
    process.send_signal(number)
    message = process.communicate(timeout=120)[1]
    assert process.returncode == 4 and "again, to go on" in message and "Traceback" not in message
    summary = summary_of(folder)
    done = {folder / entry["folder"] for entry in summary["members"] if entry["completed"]}
    assert not summary["completed"] and len(done) < 4
    stamps = {path: (path / "summary.json").stat().st_mtime_ns for path in done}
    assert main(words) == 0 and summary_of(folder)["completed"]
    assert all((path / "summary.json").stat().st_mtime_ns == stamp for path, stamp in stamps.items())


def test_a_sweep_without_its_summary_whose_members_are_all_completed_is_put_together(run_text):
    folder, code = run_text(SWEEP)
    assert code == 0
    table = (folder / "table.csv").read_text()
    for name in ("summary.json", "table.csv"):
        (folder / name).unlink()
    assert run_text(SWEEP)[1] == 0
    assert summary_of(folder)["completed"] and (folder / "table.csv").read_text() == table


def test_schedulers_that_cannot_be_used(run_text, capsys):
    folder, code = run_text(SWEEP, "--scheduler", "tcp://127.0.0.1:9")
    assert code == 2 and "no Dask scheduler answers at 'tcp://127.0.0.1:9'" in capsys.readouterr().err
    assert not folder.exists()
    assert run_text(dumps(parse(CONVERGENCE).base), "--scheduler", "tcp://127.0.0.1:9")[1] == 2
    assert "only a sweep runs on a cluster" in capsys.readouterr().err


def test_what_is_not_installed_is_named_with_the_extra_that_brings_it(run_text, monkeypatch, capsys):
    for name in ("distributed", "dask.array"):
        monkeypatch.setitem(sys.modules, name, None)
    folder, code = run_text(SWEEP)
    assert code == 2 and "a sweep needs distributed" in (said := capsys.readouterr().err) and "'hydro[dask]'" in said
    assert not folder.exists()
    with pytest.raises(NotInstalled, match=r"open_run needs dask\.array.*'hydro\[dask\]'"):
        hydro.open_run(folder)


def test_a_table_without_pyarrow_is_a_csv_file(tmp_path, monkeypatch):
    monkeypatch.setattr("hydro.studies.table.find_spec", {}.get)
    write_table(tmp_path / "table.csv", [{"a": 1, "b": [1, 2]}, {"a": None, "b": "x"}])
    assert (tmp_path / "table.csv").read_text() == 'a,b\n1,"[1, 2]"\n,x\n'
    assert [path.name for path in tmp_path.iterdir()] == ["table.csv"]


def test_a_member_on_a_worker_has_one_thread(monkeypatch):
    seen = []
    monkeypatch.setattr("hydro.studies.cluster.run_member", lambda *_: seen.append(numba.get_num_threads()) or {})
    before = numba.get_num_threads()
    assert work(dumps(parse(CONVERGENCE).base), "folder")["completed"] and seen == [1]
    numba.set_num_threads(before)
