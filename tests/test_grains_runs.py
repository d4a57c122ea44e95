"""Grains as a person meets them: decks, folders, restart, studies."""

from __future__ import annotations

import csv
import json
import math

import numpy as np
import pytest
import xarray
from conftest import PROBLEMS, summary_of
from matplotlib.figure import Figure

import hydro
from hydro.choices import GRAIN_COLOURS
from hydro.cli import main
from hydro.deck import changed, dumps, load, parse
from hydro.deck.quantities import LENGTH
from hydro.errors import DeckError
from hydro.grains import books
from hydro.grains.cells import arena
from hydro.grains.dynamics import Dynamics
from hydro.grains.integrator import dynamics_again, dynamics_of, first_dynamics
from hydro.grains.walls import ElasticWall
from hydro.initial import initial_state
from hydro.kinds.grains import describe, sawtooth_heat
from hydro.movies.frames import frames, read_frame
from hydro.output.checkpoint import read_checkpoint, write_checkpoint
from hydro.output.folder import RunFolder
from hydro.pictures.grains import GREY, HUES, draw, show
from hydro.pictures.sweep import ensemble
from hydro.studies.members import members_of, run_member, scalars_of

# 178 grains.
FEW = (
    "gas.L=300", "gas.K=0.0255", "mesh.cells=[4,8]", "time.end=2.0", "output.times=[1.0,2.0]", "grains.window=1.0",
    "output.history_every=0.25",
)  # fmt: skip
DRIVES = {
    "random-phase": (),
    "sinusoidal": ("grains.drive=sinusoidal", "grains.amplitude=0.01"),
    "sawtooth": ("grains.drive=sawtooth", "grains.amplitude=0.01"),
    "thermal": ("wall.kind=thermal",),
}
CLOCKS = ("wall_seconds", "compile_seconds", "collisions_per_second", "peak_memory_bytes")


def history_of(folder):
    with (folder / "history.csv").open() as file:
        return list(csv.DictReader(file))


def test_a_run_of_grains_leaves_a_complete_folder(run_deck):
    words = (*FEW, "output.checkpoint_every=0.4", "output.movie=true", "movie.gif=false")
    folder, code = run_deck("grains_small", *words)
    assert code == 0
    summary = summary_of(folder)
    deck = load(PROBLEMS / "grains_small.toml", words)
    assert load(folder / "deck.toml") == deck
    expected = 2.0 * 0.05 * 2.0 / (math.sqrt(3.0) * deck.gas.diameter**2)
    assert summary["kind"] == "grains" and summary["completed"] and summary["time"] == 2.0
    assert summary["grains"] == round(expected) and summary["wall"] == "RandomPhaseWall"
    assert summary["collisions"] > 100 and summary["wall_hits"] > 100 and summary["soft_collisions"] == 0
    assert abs(summary["energy_ledger"]["residual"]) < 1e-10 and abs(summary["mass_drift"]) < 1e-12
    assert summary["smallest_gap"] > -1e-12
    assert [row["time"] for row in summary["snapshots"]] == [1.0, 2.0]
    for row in summary["snapshots"]:
        assert 0.0 < row["wall_min"] < row["wall_max"] < 1.0
        assert 0.0 < row["gas_density_error"] < row["gas_density"]
        assert (folder / "checkpoints" / row["checkpoint"]).exists()
    saved = [read_checkpoint(path) for path in sorted(folder.glob("checkpoints/*.h5"))]
    assert [moment.time for moment in saved] == pytest.approx([0.4, 0.8, 1.0, 1.2, 1.6, 2.0])
    assert all(moment.memory["motion"].shape == (summary["grains"], 5) for moment in saved)
    assert {path.name for path in folder.glob("pictures/*.png")} == {
        "density.png", "density_0001.png", "density_0002.png", "grains_0001.png", "grains_0002.png", "history.png",
    }  # fmt: skip
    *_, last_frame = frames(folder / "frames")
    averages = saved[-1].memory["look_fields"][:, 0].mean(axis=0)
    assert read_frame(last_frame) == pytest.approx(averages, rel=1e-6)
    rows = history_of(folder)
    assert len(rows) == 9 and float(rows[-1]["time"]) == 2.0
    assert float(rows[-1]["wall_max"]) == summary["snapshots"][-1]["wall_max"]


def test_fields_of_a_checkpoint_are_those_of_its_grains(run_deck):
    """Mass and energy by cell add up to those of the grains, scaled by n_c."""
    folder, _ = run_deck("grains_small", *FEW, "output.pictures=false")
    saved, summary = read_checkpoint(sorted(folder.glob("checkpoints/*.h5"))[-1]), summary_of(folder)
    scale = 2.0 / (math.sqrt(3.0) * summary["diameter"] ** 2)
    velocities = saved.memory["motion"][:, 2:4]
    assert saved.mesh.integral(saved.conserved[0]) * scale == pytest.approx(summary["grains"], rel=1e-12)
    assert saved.mesh.integral(saved.conserved[3]) * scale == pytest.approx(0.5 * (velocities**2).sum(), rel=1e-12)
    looks = saved.memory["look_fields"].mean(axis=0)
    assert float(looks[0, -1] @ saved.mesh.dy) / 2.0 == pytest.approx(summary["snapshots"][-1]["gas_density"])


@pytest.mark.parametrize("drive", DRIVES)
def test_an_interrupted_run_of_grains_ends_in_the_same_bits(run_deck, drive):
    """Interrupted within a window, behind a snapshot: grains, looks, books, history and summary."""
    words = (*FEW, *DRIVES[drive], "output.checkpoint_every=0.3", "output.pictures=false")
    whole, _ = run_deck("grains_small", *words, folder="whole")
    broken, _ = run_deck("grains_small", *words, folder="broken")
    files = sorted(broken.glob("checkpoints/*.h5"))
    assert read_checkpoint(files[4]).time == pytest.approx(1.2)
    for path in (*files[5:], broken / "summary.json"):
        path.unlink()
    assert main(["restart", str(broken), "--quiet"]) == 0
    first, second = (read_checkpoint(sorted(folder.glob("checkpoints/*.h5"))[-1]) for folder in (whole, broken))
    assert first.time == second.time == 2.0 and first.steps == second.steps and first.ledger == second.ledger
    assert np.array_equal(first.conserved, second.conserved)
    assert first.memory.keys() == second.memory.keys() and first.memory["look_times"].size == 40
    counts = [moment.memory.pop("counts") for moment in (first, second)]
    search = [books.STALE, books.CROSSINGS]  # all is foreseen anew, in new cells
    assert np.array_equal(*np.delete(counts, search, axis=1))
    assert all(np.array_equal(first.memory[name], second.memory[name]) for name in first.memory)
    assert history_of(whole) == history_of(broken)
    summaries = [
        {key: value for key, value in summary_of(folder).items() if key not in CLOCKS} for folder in (whole, broken)
    ]
    assert summaries[0] == summaries[1]


def test_grains_go_further_than_they_did_but_not_as_other_grains(run_deck, capsys):
    folder, _ = run_deck("grains_small", *FEW, "output.pictures=false")
    assert main(["restart", str(folder), "gas.L=200", "--quiet"]) == 2
    assert "gas.L" in capsys.readouterr().err
    assert main(["restart", str(folder), "grains.seed=5", "--quiet"]) == 2
    assert "grains.seed" in capsys.readouterr().err
    assert main(["restart", str(folder), "time.end=2.5", "output.times=[1.0,2.5]", "--quiet"]) == 0
    assert summary_of(folder)["time"] == 2.5
    assert main(["restart", str(folder)]) == 0
    assert "complete at t = 2.5" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["gas.mu=0.01"], "gas.mu"),
        (["gas.K=0"], "gas.K"),
        (["gas.f=0.9999"], "gas.f"),
        (["grains.drive=random"], "grains.drive"),
        (["grains.seed=-1"], "grains.seed"),
        (["grains.seed=1.5"], "grains.seed"),
        (["grains.amplitude=0.6"], "grains.amplitude"),
        (["grains.window=0"], "grains.window"),
        (["grains.contact_time=-1"], "grains.contact_time"),
        (["time.integrator=godunov"], "time.integrator"),
        (["scheme.limiter=mc"], "scheme"),
        (["initial={kind='manufactured'}"], "initial.kind"),
        (["wall.kind=elastic", "box.periodic=['x']", "gas.K=0.5", "gas.L=1", "gas.f=0.5"], "three cells"),
        (["gas.K=0.9", "gas.L=1"], "two grains or more"),
    ],
    ids=lambda words: words[0] if isinstance(words, list) else "",
)
def test_bad_decks_of_grains_end_with_exit_code_2(words, expected, tmp_path, capsys):
    code = main([str(PROBLEMS / "grains_small.toml"), *words, "--output", str(tmp_path / "run")])
    message = capsys.readouterr().err
    assert code == 2 and expected in message and "Traceback" not in message
    assert not (tmp_path / "run").exists()


OUTRIGHT = """
kind = "grains"
gas = { mu = 2.41 }
box = { aspect_ratio = 2.0 }
mesh = { cells = [4, 8] }
wall = { kind = "vibrating", W = 114.0 }
initial = { kind = "uniform", temperature = 1.0 }
time = { end = 1.0 }
grains = { diameter = 0.02, restitution = 0.99, number = 300 }
"""


def test_grains_may_be_given_outright():
    """Diameter and restitution to the bit; L, f and K follow, and the deck writes them as comments only."""
    deck = parse(OUTRIGHT)
    grains = dynamics_of(deck, initial_state(deck))
    assert (grains.arena.diameter, grains.arena.restitution, grains.number) == (0.02, 0.99, 300)
    assert pytest.approx(32.0 / (3.0 * 2.26) / 0.02**2 * (1.0 - 0.99**2)) == deck.gas.L
    assert pytest.approx(300 * math.sqrt(3.0) / 2.0 * 0.02**2 / 2.0) == deck.gas.f
    assert pytest.approx(2.41 * 0.02) == deck.gas.K
    assert parse(dumps(deck)) == deck and f"# gas.L = {deck.gas.L!r}" in dumps(deck) and "\nL = " not in dumps(deck)
    assert any(f"L = {deck.gas.L:.6g}, f = 0.0519615" in line for line in describe(deck))
    assert pytest.approx(deck.gas.L / 4.0) == changed(deck, {"grains.diameter": 0.04}).gas.L
    for number in range(2, 400, 40):
        other = changed(deck, {"grains.number": number})
        assert dynamics_of(other, initial_state(other)).number == number


def test_the_number_of_grains_given_outright_may_follow_from_the_area_fraction():
    deck = parse(OUTRIGHT, ["gas.f=0.05", "grains={diameter=0.02, restitution=0.99}"])
    assert (deck.gas.f, deck.diameter, deck.restitution) == (0.05, 0.02, 0.99) and parse(dumps(deck)) == deck
    assert dynamics_of(deck, initial_state(deck)).number == round(0.05 * 4.0 / math.sqrt(3.0) / 0.02**2)


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (["grains.diameter=0.9", "grains.number=3"], "gas.f follows from it"),
        (["grains.diameter=0.3", "grains.number=25"], "grains.number: 25 grains do not fit"),
    ],
)
def test_grains_that_do_not_fit_are_refused_by_what_the_deck_says_of_them(words, problem):
    with pytest.raises(DeckError, match=problem):
        deck = parse(OUTRIGHT, words)
        dynamics_of(deck, initial_state(deck))


@pytest.mark.parametrize(
    "words",
    [
        ["box.aspect_ratio=0.01", "grains.number=20"],
        ["grains.diameter=0.9", "grains.number=2"],
        ["grains.diameter=0.53", "grains.number=3"],
        ["mesh.cells=[32,64]"],
    ],
    ids=str,
)
def test_few_grains_in_boxes_of_any_shape(words, tmp_path):
    """Narrow boxes, large grains, and cells that hold none."""
    path = tmp_path / "deck.toml"
    path.write_text(OUTRIGHT)
    assert main([str(path), *words, "output.pictures=false", "--output", str(tmp_path / "run"), "--quiet"]) == 0
    summary = summary_of(tmp_path / "run")
    assert summary["smallest_gap"] > -1e-12
    assert 0.0 <= summary["snapshots"][-1]["wall_min"] <= summary["snapshots"][-1]["wall_max"]


def test_grains_begin_as_a_checkpoint_has_them(run_deck, capsys):
    """To the last digits, of another deck; not more of them, nor larger ones."""
    folder, _ = run_deck("grains_small", *FEW, "box.periodic=['y']", "output.pictures=false")
    path = sorted(folder.glob("checkpoints/*.h5"))[-1]
    words = [*FEW, "box.periodic=['y']", f"initial={{kind='checkpoint', path='{path}'}}"]
    deck = load(PROBLEMS / "grains_small.toml", [*words, "grains.drive=sawtooth"])
    then, now = dynamics_again(deck, read_checkpoint(path).memory), first_dynamics(deck)
    assert now.time == 0.0 and now.places == pytest.approx(then.places, abs=1e-14)
    assert np.array_equal(now.velocities, then.velocities) and now.smallest_gap > -1e-12
    assert any(line.startswith(f"{now.number} grains") for line in describe(deck))
    assert not any("gas.f is not used" in line for line in describe(deck))
    for changes, key in (
        (["gas.f=0.06"], "initial.path: it has 178 grains, and the deck 213"),
        (["gas.K=0.05", f"gas.f={0.05 * (0.05 / 0.0255) ** 2}", "gas.L=10"], "initial.path: its grains overlap"),
        ([f"initial={{kind='checkpoint', path='{path}', refill=true}}"], "initial.refill"),
    ):
        refused = load(PROBLEMS / "grains_small.toml", [*words, *changes])
        for begin in (first_dynamics, describe):
            with pytest.raises(DeckError, match=key):
                begin(refused)
    flow = load(PROBLEMS / "fig4.toml", ["mesh.cells=[4,8]", words[-1]])
    averages = read_checkpoint(path).memory["look_fields"].mean(axis=0)
    assert initial_state(flow).conserved == pytest.approx(averages, rel=1e-12)


def test_grains_take_the_mass_of_a_flow_and_check_says_so(run_deck):
    flow, _ = run_deck("fig4", "mesh.cells=[4,8]", "time.end=0.1", "output.times=[0.1]", "output.pictures=false")
    (path,) = flow.glob("checkpoints/*t0.1.h5")
    deck = load(PROBLEMS / "grains_small.toml", [*FEW, f"initial={{kind='checkpoint', path='{path}'}}"])
    lines = describe(deck)
    assert any(line.startswith("83 grains") for line in lines)
    assert any("gas.f is not used: the initial state has the mean density 0.0235" in line for line in lines)
    assert not any("gas.f is not used" in line for line in describe(load(PROBLEMS / "grains_small.toml", FEW)))


def test_check_refuses_a_lone_grain():
    with pytest.raises(DeckError, match="there must be two grains or more"):
        describe(load(PROBLEMS / "grains_small.toml", [*FEW, "gas.f=1e-4"]))


def test_cells_without_grains(run_deck, capsys):
    """Movies on a logarithmic scale leave them white; a flow cannot start from them, refilled or not."""
    sparse = (
        "gas.f=0.003",
        "grains.window=0.1",
        "output.pictures=false",
        "output.movie=true",
        "movie.gif=false",
        "movie.scale=log",
    )
    folder, code = run_deck("grains_small", *FEW, *sparse)
    assert code == 0 and (folder / "movie.mp4").exists()
    assert main(["overlay", str(folder), str(folder), "--movie", "--quiet", "--output", str(folder.parent / "o")]) == 0
    path = sorted(folder.glob("checkpoints/*.h5"))[-1]
    assert read_checkpoint(path).memory["look_fields"].mean(axis=0)[0].min() == 0.0
    for refill in ("true", "false"):
        start = f"initial={{kind='checkpoint', path='{path}', refill={refill}}}"
        assert run_deck("fig4", "mesh.cells=[4,8]", "gas.f=0.05", start, folder="flow")[1] == 2
        assert "cells would leave 0 < n < 1" in capsys.readouterr().err


def test_grains_of_a_wider_box_are_refused(run_deck):
    """Before a wall that swings far out, and in a box that was periodic, grains get to where others have none."""
    far = ("grains.drive=sinusoidal", "grains.amplitude=0.3")
    folder, _ = run_deck("grains_small", *FEW, *far, "output.pictures=false", "output.times=[0.01]", "time.end=0.01")
    (path,) = folder.glob("checkpoints/*.h5")
    saved = read_checkpoint(path)
    saved.memory["motion"][0, :2] = 1.2, 1.0  # where the wall was at the start
    write_checkpoint(path, saved)
    start = f"initial={{kind='checkpoint', path='{path}'}}"
    assert first_dynamics(load(PROBLEMS / "grains_small.toml", [*FEW, *far, start])).places.max(axis=0)[0] > 1.1
    for wall in ([], ["grains.drive=sawtooth", "grains.amplitude=0.1"]):
        with pytest.raises(DeckError, match="out of the box"):
            first_dynamics(load(PROBLEMS / "grains_small.toml", [*FEW, *wall, start]))


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_any_restitution_may_be_given_outright(restitution):
    deck = parse(OUTRIGHT, [f"grains.restitution={restitution}"])
    assert deck.restitution == restitution and deck.gas.restitution == pytest.approx(restitution, abs=1e-6)


@pytest.mark.parametrize(
    ("words", "key", "problem"),
    [
        (["gas.L=100"], "gas.L", "given beside grains.diameter, from which it follows"),
        (["gas.f=0.1"], "gas.f", "given beside grains.diameter"),
        (["gas.K=0.1"], "gas.K", "given beside grains.diameter"),
        (["grains={diameter=0.02}"], "grains.restitution", "or none of them"),
        (["grains={number=300}"], "grains.diameter", "or none of them"),
        (["grains={diameter=0.02, restitution=0.9}"], "gas.f", "required"),
        (["grains={seed=1}"], "gas.L", "required"),
        (["grains.diameter=1.0"], "grains.diameter", "less than 1"),
        (["grains.restitution=1.1"], "grains.restitution", "at most 1"),
        (["grains.number=1"], "grains.number", "at least 2"),
        (["grains.number=1.5"], "grains.number", "whole number"),
        (["grains.number=30000"], "grains.diameter", "gas.f follows from it: 5.196"),
    ],
)
def test_grains_are_given_in_exactly_one_way(words, key, problem):
    with pytest.raises(DeckError) as error:
        parse(OUTRIGHT, words)
    assert {complaint.key: complaint.problem for complaint in error.value.complaints}.get(key, "").count(problem)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ([], "driving wall: random-phase; A omega = 0.9259; inside the tongue; good below; A omega/T^(1/2) at x=1 ="),
        (["grains.drive=sinusoidal", "grains.amplitude=0.01"], "omega = 92.59 T_*; small amplitude; fast vibration"),
        (["grains.drive=sawtooth"], "work p u: about 0.744 times; omega = 925.9 T_*"),
        (["wall.kind=thermal", "box.aspect_ratio=1"], "driving wall: thermal; the extended state is stable"),
        (["wall.W=0"], "driving wall: elastic; no extended state"),
    ],
)
def test_check_says_where_grains_and_their_wall_lie(words, told):
    """Beside the marginal curve, and within the assumptions of the paper's equations."""
    lines = "\n".join(describe(load(PROBLEMS / "grains_small.toml", words)))
    assert all(part in lines for part in told.split("; ")), lines
    assert ("small amplitude" in lines) == any("drive" in word for word in words)


@pytest.mark.parametrize("speed", [0.14, 0.5, 2.0])
def test_heat_of_a_sawtooth_wall_is_that_of_lone_grains(speed):
    """Grains that come to it as a Maxwellian flux, by the quadrature of what each gains: 2 u (v + u)."""
    u, v = speed / math.pi, np.linspace(0.0, 12.0, 100_001)
    heat = np.trapezoid(v * np.exp(-0.5 * v**2) * 2.0 * u * (v + u), v) / math.sqrt(2.0 * math.pi)
    assert sawtooth_heat(speed) == pytest.approx(heat / (math.sqrt(2.0 / math.pi) * speed**2), rel=1e-6)


def test_grains_of_an_experiment_have_its_numbers_and_its_amplitude():
    text = (PROBLEMS / "experiment.toml").read_text()
    text = text.replace('"evolution"', '"grains"').replace('integrator = "lagrange-remap"\n', "")
    deck = parse(text)
    d, L_x, A = (LENGTH.si(getattr(deck.experiment, key)) for key in ("d", "L_x", "A"))
    assert deck.diameter == pytest.approx(d / L_x) and deck.restitution == pytest.approx(deck.experiment.r)
    assert deck.grains.amplitude == pytest.approx(A / L_x) and parse(dumps(deck)) == deck
    assert dynamics_of(deck, initial_state(deck)).number == deck.experiment.N
    with pytest.raises(DeckError, match=r"beside \[experiment\]"):
        parse(text, ["grains={diameter=0.01, restitution=0.9, number=9}"])


def test_an_inelastic_collapse_ends_with_its_last_state_saved(run_deck, capsys):
    """Grains that lose nearly all their energy in a collision, without a contact time."""
    words = ("gas.L=1e4", "gas.K=0.0213", "mesh.cells=[4,8]", "time.end=200.0", "output.times=[200.0]")
    folder, code = run_deck("grains_small", *words, "output.pictures=false")
    assert code == 3
    assert f"to go on from it: python -m hydro restart {folder} grains.contact_time=1e-6" in capsys.readouterr().err
    summary, saved = summary_of(folder), read_checkpoint(sorted(folder.glob("checkpoints/*.h5"))[-1])
    assert not summary["completed"] and summary["time"] == saved.time == saved.memory["time"][0]
    assert summary["smallest_gap"] > -1e-12 and abs(summary["energy_ledger"]["residual"]) < 1e-10
    assert main(["restart", str(folder), "--quiet"]) == 3
    assert len(list(folder.glob("checkpoints/*.h5"))) == 1
    end = saved.time + 1.0
    further = ["grains.contact_time=1e-3", f"time.end={end}", f"output.times=[{end}]"]
    assert main(["restart", str(folder), *further]) == 0
    summary = summary_of(folder)
    assert summary["completed"] and summary["soft_collisions"] > 0
    assert f"{summary['soft_collisions']} of the collisions were elastic" in capsys.readouterr().out


def test_states_report_and_closing_lines_of_grains(run_deck, capsys):
    folder, code = run_deck("grains_small", *FEW, "output.times=[0.05,2.0]", options=())
    assert code == 0
    assert "grains" in capsys.readouterr().out
    assert json.loads((folder / "summary.json").read_text())["snapshots"][0]["wall_max_error"] is None
    assert main(["report", str(folder), "--quiet"]) == 0
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "Energy ledger" in page and page.count("<img") >= 5
    assert main(["restart", str(folder)]) == 0
    assert hydro.open_run(folder).sizes == {"time": 2, "x": 4, "y": 8}
    assert main(["compare", str(folder), "auto"]) == 0


def test_a_sweep_over_seeds_knows_the_numbers_of_grains(run_deck, tmp_path):
    """Seeds differ in their grains, not in their number."""
    deck = tmp_path / "seeds.toml"
    axes = "[{keys = ['grains.seed'], values = [1, 2]}]"
    deck.write_text(
        f"kind = 'sweep'\nbase = {{deck = '{PROBLEMS / 'grains_small.toml'}'}}\nsweep = {{axes = {axes}}}\n"
    )
    study = load(deck, [f"base.{word}" for word in (*FEW, "output.pictures=false")])
    first, second = (
        scalars_of(member.deck, run_member(member.deck, RunFolder(tmp_path / str(member.number))))
        for member in members_of(study)
    )
    assert first.keys() == set(study.base.scalars) and None not in first.values()
    assert first["grains"] == second["grains"] and first["collisions"] != second["collisions"]


def test_grains_are_drawn_in_every_colour_of_the_deck(tmp_path):
    deck = load(PROBLEMS / "grains_small.toml", FEW)
    grains = dynamics_of(deck, initial_state(deck))
    images = set()
    for colour in GRAIN_COLOURS:
        draw(tmp_path / "grains.png", grains, colour)
        images.add((tmp_path / "grains.png").read_bytes())
    assert len(images) == len(GRAIN_COLOURS)


@pytest.mark.parametrize("sizes", [(3, 2, 1, 1), (3, 2), (1, 1), (2,) * 9])
def test_the_largest_clusters_have_hues_of_their_own(sizes):
    """Rows of grains in touch, far from each other."""
    d = 0.01
    row = np.repeat(np.arange(len(sizes)), sizes)
    column = np.concatenate([np.arange(size) for size in sizes])
    places = np.stack([0.1 + 1.1 * d * column, 0.05 + 0.1 * row], axis=1)
    grains = Dynamics(arena(d, 1.0, 1.0), ElasticWall(), places, np.zeros_like(places))
    axis = Figure().add_subplot()
    show(axis, grains, "cluster")
    hued = sum(size > 1 for size in sizes[: len(HUES)])
    wanted = [HUES[k] if k < hued else GREY for k in row]
    assert np.allclose(axis.collections[0].get_facecolor()[:, :3], wanted)
    rest = sum(sizes[hued:])
    listed = [text.get_text() for text in axis.get_legend().get_texts()]
    assert listed == [*(f"{size}" for size in sizes[:hued]), *([f"{rest}, others"] if rest else [])]


def test_pictures_of_sweeps_average_over_seeds():
    """Means and their standard errors; a sweep over nothing but seeds is shown as it is."""
    numbers = np.array([[1.0, 2.0, 6.0], [4.0, 4.0, np.nan]])
    values = xarray.DataArray(numbers, {"gas.L": [1.0, 2.0], "grains.seed": [1.0, 2.0, 3.0]}, name="wall_max")
    means, errors = ensemble(values)
    assert means.dims == errors.dims == ("gas.L",) and means.name == "wall_max"
    assert means.values == pytest.approx([3.0, 4.0])
    assert errors.values == pytest.approx([math.sqrt(7.0 / 3.0), 0.0])
    alone, none = ensemble(values[0])
    assert alone.identical(values[0]) and none is None
