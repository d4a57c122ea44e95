"""Comparison of a run with a steady state: alignment, distances, rates."""

from __future__ import annotations

import json
import re
from pathlib import Path
from types import SimpleNamespace

import imageio.v3 as imageio
import numpy as np
import pytest
from conftest import PROBLEMS

from hydro.cli import main
from hydro.compare.exponential import FEWEST, NoStretch, exponential_stretch
from hydro.compare.overlay import Overlaid
from hydro.deck import dumps, load, parse
from hydro.deck.evolution import Movie
from hydro.mesh import Mesh
from hydro.movies.movie import Side, Source
from hydro.movies.moving import NAME, Board, MovingPicture
from hydro.observables.clustering import CLUSTERING
from hydro.output.checkpoint import Checkpoint, read_checkpoint, write_checkpoint
from hydro.output.folder import RunFolder
from hydro.output.history import read_rows
from hydro.setup import gas_of, mesh_of
from hydro.state import State
from hydro.steady.growth import growth_of, sector_parts, with_mode
from hydro.steady.localized import SteadyState, steady_state
from hydro.steady.nearest import aligned, candidates, distance, images, translated
from hydro.walls import VibratingWall

STEADY = """
kind = "steady"
gas = { L = 5e4, f = 0.0235 }
mesh = { cells = [16, 16] }
wall = { kind = "vibrating" }
steady = { wave = 1 }
"""
FULL = ("steady.wave=2", "box.aspect_ratio=2.0", "mesh.cells=[16,32]")
GAS = ("gas.K=2e-3", "gas.tau=200.0")  # of steady decks, by default
HALF_RUN = ("box.aspect_ratio=1.0", "mesh.cells=[16,16]")


def steady_deck(*overrides):
    return parse(STEADY, overrides)


def state_of(deck, periodic=(False, False)) -> SteadyState:
    """The state of a steady deck."""
    mesh = mesh_of(deck)
    mesh = Mesh(mesh.x_faces, mesh.y_faces, periodic)
    return steady_state(
        gas_of(deck), VibratingWall(deck.gas.K * deck.wall.W), mesh, deck.gas.f, deck.steady.wave, deck.steady.shifted
    )


@pytest.fixture
def steady_run(tmp_path):
    """Writes the folder of a steady run, of the deck above with overrides, without computing growth rates."""

    def write(*overrides, name="steady"):
        deck = steady_deck(*overrides)
        folder = RunFolder(tmp_path / name)
        folder.prepare(dumps(deck))
        write_checkpoint(folder.checkpoints / "steady.h5", Checkpoint.of(state_of(deck).state, dumps(deck)))
        return folder.path

    return write


@pytest.fixture
def fake_run(tmp_path):
    """Writes the folder of a run with given states, of the deck of Fig. 4 with overrides."""

    def write(states, *overrides, name="run"):
        deck = load(PROBLEMS / "fig4.toml", (*GAS, *overrides))
        folder = RunFolder(tmp_path / name)
        folder.prepare(dumps(deck))
        for number, state in enumerate(states, start=1):
            write_checkpoint(folder.checkpoints / f"{number:04d}.h5", Checkpoint.of(state, dumps(deck)))
        return folder.path

    return write


def compared(run, steady) -> dict:
    """What `compare` writes."""
    assert main(["compare", str(run), str(steady), "--quiet"]) == 0
    assert {path.name for path in (run / "compare").iterdir()} == {"compare.json", "distance.png", "states.png"}
    return json.loads((run / "compare" / "compare.json").read_text())


def evolved(run_deck, start, *overrides):
    """A run of the deck of Fig. 4 from a checkpoint."""
    folder, code = run_deck("fig4", "initial.kind=checkpoint", f"initial.path={start}", *GAS, *overrides)
    assert code == 0
    return folder


# The exponential stretch


def test_a_stretch_between_a_transient_and_a_floor():
    t = np.linspace(0.0, 100.0, 101)
    values = np.exp(-1.5 * t) + 1e-2 * np.exp(-0.2 * t) + 1e-9
    found = exponential_stretch(t, values)
    assert found.rate == pytest.approx(-0.2, rel=0.01) and found.error < 0.01
    assert found.start < 15.0 and 60.0 < found.end < 80.0
    assert found.points == np.count_nonzero((t >= found.start) & (t <= found.end))
    assert found.at_start == pytest.approx(1e-2 * np.exp(-0.2 * found.start), rel=0.05)


def test_a_stretch_of_growth_with_uneven_times():
    t = np.sort(np.random.default_rng(2).uniform(0.0, 10.0, 40))
    found = exponential_stretch(t, 3e-5 * np.exp(0.7 * t))
    assert found.rate == pytest.approx(0.7, rel=1e-9) and found.error < 1e-9
    assert (found.start, found.end, found.points) == (t[0], t[-1], 40)


def test_curves_without_a_stretch_say_so():
    t = np.linspace(1.0, 50.0, 60)
    with pytest.raises(NoStretch, match="no exponential stretch"):
        exponential_stretch(t, t**-1.0)
    with pytest.raises(NoStretch, match="no exponential stretch"):
        exponential_stretch(t, 1.0 + 0.01 * np.exp(-t))
    with pytest.raises(NoStretch, match=f"6 checkpoints are too few: a rate needs {FEWEST}"):
        exponential_stretch(t[:6], np.exp(-t[:6]))
    with pytest.raises(NoStretch, match="0 checkpoints"):
        exponential_stretch(t, np.zeros(60))


# Alignment


@pytest.mark.parametrize(
    ("overrides", "run_overrides", "image", "alignment"),
    [
        ((), HALF_RUN, 0, "as it is"),
        ((), HALF_RUN, 1, "mirrored in y"),
        (FULL, FULL[2:], 0, "as it is"),
        (FULL, FULL[2:], 1, "shifted by half a wave"),
        ((*FULL, "steady.shifted=true"), FULL[2:], 1, "shifted by half a wave"),
    ],
)
def test_the_steady_state_is_aligned_with_the_run(steady_run, fake_run, overrides, run_overrides, image, alignment):
    shown = list(images(state_of(steady_deck(*overrides))))
    result = compared(fake_run([shown[image].state], *run_overrides), steady_run(*overrides))
    assert result["alignment"] == alignment
    (row,) = result["checkpoints"]
    assert row["density"]["max"] < 1e-10 and row["temperature"]["L1"] < 1e-10
    assert row["cluster_position"] == pytest.approx(result["steady_state"]["cluster_position"], abs=1e-9)
    assert row["wall_max"] == pytest.approx(result["steady_state"]["wall_max"], rel=1e-9)


def test_a_run_that_leaves_is_aligned_with_where_it_was_nearest(steady_run, fake_run):
    """Nearest to the mirror image first, then to the state itself, but less so."""
    itself, mirrored = images(state_of(steady_deck()))
    mix = State(itself.state.gas, itself.state.mesh, 0.6 * itself.state.conserved + 0.4 * mirrored.state.conserved)
    result = compared(fake_run([mirrored.state, mix], *HALF_RUN), steady_run())
    assert result["alignment"] == "mirrored in y"


def test_alignment_in_a_periodic_box():
    steady = state_of(steady_deck(*FULL), (False, True))
    mesh, there = steady.balance.mesh, steady.state
    by_cells = State(there.gas, mesh, np.roll(there.conserved, 5, axis=2))
    moved, shift = aligned(by_cells, steady)
    assert shift == pytest.approx(-5.0 * mesh.dy[0], rel=1e-12)
    assert moved.density == pytest.approx(there.density, rel=1e-12)
    within = State.of(
        there.gas, mesh, *(np.exp(translated(np.log(f), mesh, 0.3)) for f in (there.density, there.temperature))
    )
    assert aligned(within, steady)[1] == pytest.approx(-0.3, abs=2e-3)
    assert (
        distance(within, steady) < 0.02 < 0.5 < distance(State.of(there.gas, mesh, 0.0235, there.temperature), steady)
    )


def test_translation_of_a_cosine():
    mesh = Mesh.rectangle((2, 16), 2.0, periodic=(False, True))
    field = np.cos(2.0 * np.pi * 3 * mesh.y / 2.0) * np.ones((2, 1))
    expected = np.cos(2.0 * np.pi * 3 * (mesh.y - 0.123) / 2.0) * np.ones((2, 1))
    assert translated(field, mesh, 0.123) == pytest.approx(expected, abs=1e-13)


def test_parts_of_all_sectors_add_up():
    field = np.random.default_rng(4).normal(size=(16, 32))
    for wave, periodic in ((0, False), (0, True), (2, False)):
        steady = state_of(steady_deck(*FULL, f"steady.wave={wave}"), (False, periodic))
        parts = list(sector_parts(steady, field))
        assert sum(parts) == pytest.approx(field, abs=1e-12)
        assert sum(np.vdot(part, part) for part in parts) == pytest.approx(np.vdot(field, field))


@pytest.mark.parametrize("periodic", [False, True])
def test_modes_lie_in_their_sector(periodic):
    steady = state_of(steady_deck(*FULL, "steady.wave=0"), (False, periodic))
    growths = growth_of(steady, 200.0, 1)
    for number, growth in enumerate(growths):
        density = growth.modes[0].density.real
        for other, part in zip(range(len(growths)), sector_parts(steady, density), strict=False):
            assert part == pytest.approx(density if other == number else 0.0 * density, abs=1e-10)


# Which state


def test_candidates_are_the_strongest_waves_that_fit():
    mesh = Mesh.rectangle((4, 32), 2.0)
    gas = gas_of(steady_deck())

    def waves(amplitudes, periodic=False):
        on = Mesh(mesh.x_faces, mesh.y_faces, (False, periodic))
        w = 3.0 + sum(a * np.cos(np.pi * m * mesh.y / 2.0) for m, a in amplitudes.items())
        return candidates(State.of(gas, on, 1.0 / (1.0 + np.exp(w)), 1.0))

    assert waves({2: 1.0, 4: 0.5, 8: 0.3, 3: 2.0}) == [0, 2, 4, 8]
    assert waves({1: 1.0, 2: 0.5, 4: 0.3}) == [0, 1, 2, 4]
    assert waves({2: 0.1, 4: 0.5, 8: 0.3}, periodic=True) == [0, 4, 8, 2]


def test_auto_finds_the_nearest_state(fake_run):
    half = state_of(steady_deck()).state
    uniform = state_of(steady_deck("steady.wave=0")).state
    result = compared(fake_run([uniform, half], *HALF_RUN), "auto")
    assert result["wave"] == 1 and [attempt["wave"] for attempt in result["tried"]] == [0, 1, 2, 4]
    assert result["tried"][2]["distance"] is None and "no localized state" in result["tried"][2]["reason"]
    assert [row["density"]["L2"] < 1e-9 for row in result["checkpoints"]] == [False, True]
    result = compared(fake_run([half, uniform], *HALF_RUN, name="other"), "auto")
    assert result["wave"] == 0 and result["rates"][0]["fit"] is None
    assert "checkpoints are too few" in result["rates"][0]["note"]


def test_a_steady_state_of_another_mesh_and_wall_strength_is_solved_on_that_of_the_run(steady_run, fake_run):
    there = state_of(steady_deck("mesh.cells=[24,20]", "mesh.stretch=2", "wall.W=50")).state
    run = fake_run([there], "box.aspect_ratio=1.0", "mesh.cells=[24,20]", "mesh.stretch=2", "wall.W=50")
    result = compared(run, steady_run())
    assert result["cells"] == [24, 20] and result["checkpoints"][0]["temperature"]["max"] < 1e-9


# Rates


@pytest.mark.parametrize(
    ("overrides", "sector", "words"),
    [
        ((), "all", ("time.end=150", "time.dt_max=2", "output.checkpoint_every=10")),
        (FULL, "antisymmetric", ("time.end=1500", "time.dt_max=20", "output.checkpoint_every=100")),
    ],
    ids=["approach", "departure"],
)
def test_a_run_from_a_mode_has_its_growth_rate(steady_run, run_deck, overrides, sector, words):
    steady = state_of(steady_deck(*overrides))
    mode = next(growth for growth in growth_of(steady, 200.0) if growth.sector == sector).modes[0]
    folder = steady_run(*overrides)
    start = folder / "checkpoints" / "mode.h5"
    write_checkpoint(start, Checkpoint.of(with_mode(steady.state, mode, 1e-3), ""))
    words = (*words, f"output.times=[{words[0].removeprefix('time.end=')}]")
    box = HALF_RUN if sector == "all" else FULL[2:]
    result = compared(evolved(run_deck, start, *box, *words), folder)
    total = result["rates"][0]
    assert total["growth_rate"] == pytest.approx(mode.growth_rate.real, rel=1e-6)
    assert total["fit"]["rate"] == pytest.approx(mode.growth_rate.real, rel=0.01)


def test_a_symmetric_run_knows_nothing_of_antisymmetric_modes(fake_run, steady_run):
    steady = state_of(steady_deck(*FULL))
    symmetric, antisymmetric = (growth.modes[0] for growth in growth_of(steady, 200.0))
    states = [with_mode(steady.state, symmetric, 10.0**-k) for k in range(2, 10)]
    for k, state in enumerate(states):
        state.time = 10.0 * k
    total, even, odd = compared(fake_run(states, FULL[2]), steady_run(*FULL))["rates"]
    assert total["growth_rate"] == even["growth_rate"] == pytest.approx(symmetric.growth_rate.real, rel=1e-6)
    assert total["fit"]["rate"] == pytest.approx(-np.log(10.0) / 10.0, rel=1e-3)
    assert odd["fit"] is None and "round-off" in odd["note"]
    assert odd["growth_rate"] == pytest.approx(antisymmetric.growth_rate.real, rel=1e-6)


def test_shear_flow_is_followed_at_the_rate_of_friction(steady_run, run_deck):
    """Momentum without divergence carries enthalpy across its gradient, so the density decays with it, at 1/tau."""
    steady = state_of(steady_deck()).state
    x, y = (np.linspace(0.0, 1.0, 17) for _ in range(2))
    stream = 1e-6 * np.outer(np.sin(np.pi * x) ** 2, np.sin(np.pi * y) ** 2)
    momentum = [np.diff(stream, axis=1) / steady.mesh.dy, -np.diff(stream, axis=0) / steady.mesh.dx[:, None]]
    stirred = steady.copy()
    stirred.conserved[1] = 0.5 * (momentum[0][1:] + momentum[0][:-1])
    stirred.conserved[2] = 0.5 * (momentum[1][:, 1:] + momentum[1][:, :-1])
    folder = steady_run()
    write_checkpoint(folder / "checkpoints" / "stirred.h5", Checkpoint.of(stirred, ""))
    words = ("time.end=1500", "output.times=[1500]", "time.dt_max=5", "output.checkpoint_every=50")
    result = compared(evolved(run_deck, folder / "checkpoints" / "stirred.h5", *HALF_RUN, *words), folder)
    fit = result["rates"][0]["fit"]
    assert result["friction_rate"] == -0.005
    assert fit["rate"] == pytest.approx(-0.005, rel=0.02) and result["rates"][0]["growth_rate"] < -0.01


def test_a_chain_in_a_periodic_box_is_free_to_move():
    """A motion along y, antisymmetric, neither grows nor decays; symmetric modes are those of a closed box."""
    closed, periodic = (state_of(steady_deck(*FULL), (False, along)) for along in (False, True))
    (even, _), (same, odd) = growth_of(closed, 200.0), growth_of(periodic, 200.0)
    assert same.rate == pytest.approx(even.rate, rel=1e-6)
    slope = np.roll(periodic.state.density, -1, axis=1) - np.roll(periodic.state.density, 1, axis=1)
    density = odd.modes[0].density.real
    correlation = np.vdot(slope, density) / np.linalg.norm(slope) / np.linalg.norm(density)
    assert abs(correlation) > 0.99 and abs(odd.rate) < 0.1 * abs(even.rate)
    assert odd.modes[1].growth_rate.real < -0.01


def test_a_run_in_a_periodic_box(fake_run, steady_run):
    steady = state_of(steady_deck(*FULL), (False, True))
    mode = growth_of(steady, 200.0)[0].modes[0]
    states = [with_mode(steady.state, mode, 0.1 * 2.0**-k) for k in range(8)]
    for k, state in enumerate(states):
        state.conserved, state.time = np.roll(state.conserved, 7, axis=2), float(k)
    result = compared(fake_run(states, FULL[2], 'box.periodic=["y"]'), steady_run(*FULL))
    total, _, odd = result["rates"]
    assert result["checkpoints"][-1]["moved"] == pytest.approx(-7 * 2.0 / 32)
    assert total["fit"]["rate"] == pytest.approx(-np.log(2.0), rel=0.01)
    assert odd["growth_rate"] < -0.01  # the motion along y is left out: alignment undoes it


# Refusals


@pytest.mark.parametrize(
    ("run_overrides", "steady_overrides", "complaint"),
    [
        (("gas.L=4e4", *HALF_RUN), (), "gas.L: 40000.0 in the run, 50000.0 in the steady state"),
        (("wall.kind=thermal", *HALF_RUN), (), "wall.kind: 'thermal' in the run, 'vibrating' in the steady state"),
        (("mesh.cells=[16,16]",), (), "box.aspect_ratio: 2.0 in the run, 1.0 in the steady state"),
        (HALF_RUN, ("gas.f=0.0236",), "gas.f: 0.0235"),
        (("wall.kind=elastic", *HALF_RUN), (), "wall.kind: no steady state to compare with"),
        (("gas.L=0", *HALF_RUN), (), "gas.L: no steady state to compare with"),
        (('box.periodic=["y"]', *HALF_RUN), (), "1 half-waves, which do not fit on the run's 16 cells in y that are"),
    ],
)
def test_states_of_another_gas_or_box_are_refused(
    run_overrides, steady_overrides, complaint, fake_run, steady_run, capsys
):
    cells = next(word for word in run_overrides if "mesh" in word)
    mesh = mesh_of(load(PROBLEMS / "fig4.toml", [word for word in run_overrides if "wall" not in word]))
    state = State.of(gas_of(steady_deck()), mesh, 0.0235, 1.0)
    run, steady = fake_run([state], cells, *run_overrides), steady_run(*steady_overrides)
    assert main(["compare", str(run), str(steady), "--quiet"]) == 2
    assert complaint in capsys.readouterr().err and not (run / "compare").exists()


def test_grains_are_compared_by_the_averages_over_their_windows(tmp_path):
    """What is compared has the wall density of the summary, not that of the last moment."""
    short = ("gas.K=0.03", "gas.L=500", "mesh.cells=[8,4]", "time.end=24", "output.times=[2,24]", "grains.window=20")
    run = tmp_path / "grains"
    assert main([str(PROBLEMS / "grains_extended.toml"), *short, "--output", str(run), "--quiet"]) == 0
    assert main(["compare", str(run), "auto", "--quiet"]) == 0
    found = json.loads((run / "compare" / "compare.json").read_text())
    last = found["checkpoints"][-1]
    assert last["time"] == 24.0 and found["wave"] == 0 and last["density"]["L2"] < 0.3
    assert last["wall_max"] == json.loads((run / "summary.json").read_text())["snapshots"][-1]["wall_max"]


def test_folders_that_cannot_be_compared_are_refused(fake_run, steady_run, tmp_path, capsys):
    def refusal(run, steady):
        assert main(["compare", str(run), str(steady)]) == 2
        message = capsys.readouterr().err
        assert "Traceback" not in message
        return message

    run, steady = fake_run([]), steady_run()
    assert "no folder of a run" in refusal(tmp_path / "nowhere", "auto")
    assert "has no checkpoints yet" in refusal(run, "auto")
    assert "kind 'steady'; only an evolution" in refusal(steady, "auto")
    run = fake_run([state_of(steady_deck()).state], *HALF_RUN, name="half")
    assert "neither the folder of a steady run nor 'auto'" in refusal(run, "atuo")
    assert "kind 'evolution', not 'steady'" in refusal(run, run)
    (steady / "checkpoints" / "steady.h5").write_bytes(b"damaged")
    assert "steady.h5" in refusal(run, steady)
    (run / "checkpoints" / "0001.h5").write_bytes(b"damaged")
    assert "0001.h5" in refusal(run, "auto")


def test_a_state_that_is_not_there_is_a_failure(fake_run, capsys):
    state = State.of(gas_of(steady_deck()), Mesh.rectangle((16, 16)), 0.9, 1.0)
    run = fake_run([state], *HALF_RUN)
    assert main(["compare", str(run), "auto", "--quiet"]) == 3
    message = capsys.readouterr().err
    assert "no steady state found" in message and "wave 0" in message and "Traceback" not in message


def test_what_is_printed(fake_run, steady_run, capsys):
    state = state_of(steady_deck()).state
    run = fake_run([state], *HALF_RUN)
    assert main(["compare", str(run), str(steady_run())]) == 0
    printed = capsys.readouterr().out
    for part in ("as it is", "largest n(0, y)", "L2", "eigenvalue", "friction, -1/tau", "results in"):
        assert part in printed


def test_a_new_run_does_not_keep_the_comparison_of_the_old_one(run_deck, steady_run):
    words = (*HALF_RUN, "time.end=0.1", "output.times=[0.1]")
    folder, _ = run_deck("fig4", *words)
    compared(folder, steady_run())
    assert run_deck("fig4", *words, options=("--quiet", "--overwrite"))[1] == 0
    assert not list((folder / "compare").iterdir())
    assert read_checkpoint(next(folder.glob("checkpoints/*.h5"))).time == 0.1


# Runs over each other


def test_grains_beside_hydrodynamics(run_deck, tmp_path, capsys):
    """What is told of each is the last row of its history; grains have errors, a flow has none."""
    words = ("gas.L=300", "gas.K=0.0255", "mesh.cells=[4,8]", "time.end=2.0", "output.times=[2.0]", "grains.window=1.0")
    grains, _ = run_deck("grains_small", *words, "output.pictures=false", folder="grains $x$")
    short = ("mesh.cells=[8,16]", "time.end=1.0", "output.times=[1.0]", "output.pictures=false")
    flow, _ = run_deck("fig4", *short, folder="flow")
    output = tmp_path / "over" / "lay"
    assert main(["overlay", str(grains), str(flow), "--output", str(output)]) == 0
    assert {path.name for path in output.iterdir()} == {"overlay.json", "history.png", "states.png"}
    rows = json.loads((output / "overlay.json").read_text())["runs"]
    assert [(row["run"], row["time"]) for row in rows] == [("grains $x$", 2.0), ("flow", 1.0)]
    for row, folder in zip(rows, (grains, flow), strict=True):
        last = read_rows(folder / "history.csv").iloc[-1]
        assert all(row[key] == last[key] for key in ("wall_max", "wall_min", "gas_density", "centre_x"))
    assert rows[0]["wall_max_error"] > 0.0 and "wall_max_error" not in rows[1]
    shown = capsys.readouterr().out
    assert re.search(rf"{rows[0]['wall_max']:.4g} ± {rows[0]['wall_max_error']:.1g}", shown) and str(output) in shown


def test_a_movie_of_runs_side_by_side(run_deck, tmp_path):
    short = ("mesh.cells=[8,16]", "time.end=1.0", "output.times=[0.5,1.0]", "output.pictures=false", "movie.gif=false")
    runs = [str(run_deck("fig4", *short, folder=name)[0]) for name in "ab"]
    assert main(["overlay", *runs, "--movie", "--quiet", "--output", str(tmp_path / "over")]) == 0
    assert not (tmp_path / "over" / "overlay.gif").exists()
    about = imageio.immeta(tmp_path / "over" / "overlay.mp4", plugin="FFMPEG")
    mesh = Mesh.rectangle((8, 16), 2.0)
    width, height = MovingPicture(mesh, CLUSTERING.span, Movie(traces=False), None, None, 1).size
    assert about["size"] == (2 * width, height + NAME) and 8.0 < about["duration"] < 12.0


def test_pictures_of_runs_have_one_scale_if_the_first_deck_says_so(run_deck, tmp_path, monkeypatch):
    ends = []

    def seen(*arguments):
        ends.append(arguments[3])
        return MovingPicture(*arguments)

    monkeypatch.setattr("hydro.movies.movie.MovingPicture", seen)
    short = ("mesh.cells=[8,16]", "time.end=0.5", "output.times=[0.5]", "output.pictures=false", "movie.gif=false")
    dilute = run_deck("fig4", *short, "movie.limits=run", folder="dilute")[0]
    dense = run_deck("fig4", *short, "gas.f=0.1", folder="dense")[0]
    for first, second in ((dilute, dense), (dense, dilute)):
        assert main(["overlay", str(first), str(second), "--movie", "--quiet", "--output", str(tmp_path / "o")]) == 0
    largest = max(read_checkpoint(path).conserved[0].max() for path in dense.glob("checkpoints/*.h5"))
    assert ends == [(0.0, largest), (0.0, largest), None, None]


def test_a_side_of_a_movie_shows_the_latest_moment():
    times = {Path(f"{time}"): time for time in (0.5, 1.0, 1.1, 3.0)}
    picture = SimpleNamespace(at=lambda time, density: (time, density[0, 0]))
    read = dict(zip(times, (np.full((4, 4), value) for value in (1.0, 2.0, 3.0, 4.0)), strict=True)).__getitem__
    side = Side(Source(times, read), Mesh.rectangle((4, 4)), picture)
    shown = [side.at(now) for now in (0.0, 0.4, 1.0, 1.05, 2.0, 2.9, 3.0, 4.0)]
    assert shown == [(0.5, 1.0), None, (1.0, 2.0), None, (1.1, 3.0), None, (3.0, 4.0), None]


def test_a_board_holds_pictures_under_their_names():
    board = Board(["a", "$b"], [(100, 60), (80, 40)])
    assert board.size == (180, 60 + NAME) and board.pixels[NAME:].min() == 255 and board.pixels[:NAME].min() < 128
    board.put(1, np.full((40, 80, 4), 7, np.uint8))
    changed = np.argwhere(board.pixels[NAME:] == 7)
    assert changed.min(axis=0).tolist() == [0, 100, 0] and changed.max(axis=0).tolist() == [39, 179, 3]


def test_runs_of_one_name_are_told_apart(run_deck, tmp_path):
    short = ("mesh.cells=[8,16]", "time.end=1.0", "output.times=[1.0]", "output.pictures=false")
    paths = [str(run_deck("fig4", *short, folder=f"{name}/run")[0]) for name in "ab"]
    assert main(["overlay", *paths, "--output", str(tmp_path / "both"), "--quiet"]) == 0
    assert [row["run"] for row in json.loads((tmp_path / "both" / "overlay.json").read_text())["runs"]] == paths


def test_a_damaged_checkpoint_is_passed_over(run_deck, tmp_path, capsys):
    """The one before it is shown: of a file whose content is not what was written, and of a truncated one."""
    short = ("mesh.cells=[8,16]", "time.end=1.5", "output.times=[0.5,1.0,1.5]", "output.pictures=false")
    run, _ = run_deck("fig4", *short)
    *_, middle, last = sorted(run.glob("checkpoints/*.h5"))
    content = bytearray(last.read_bytes())
    content[-100] ^= 1
    last.write_bytes(content)
    assert Overlaid.of(run).time == 1.0 and last.name in capsys.readouterr().err
    middle.write_bytes(middle.read_bytes()[:2000])
    assert Overlaid.of(run).time == 0.5 and middle.name in capsys.readouterr().err
    assert main(["overlay", str(run), "--quiet", "--output", str(tmp_path / "over")]) == 0


def test_what_cannot_be_overlaid_is_refused(run_deck, steady_run, tmp_path, capsys):
    flow, _ = run_deck("fig4", "mesh.cells=[8,16]", "time.end=1.0", "output.times=[1.0]", "output.pictures=false")
    history = (flow / "history.csv").read_text()
    for words, problem in (
        ([str(tmp_path / "nothing")], "no folder of a run"),
        ([str(steady_run())], "'steady'; only evolutions and grains"),
        ([str(flow), "--output", str(flow)], "is the folder of a run; choose another"),
    ):
        assert main(["overlay", "--output", str(tmp_path / "over"), *words]) == 2
        assert problem in capsys.readouterr().err and not (tmp_path / "over").exists()
    assert main(["overlay", str(flow), "--output", str(flow / "history.csv")]) == 2
    assert "history.csv cannot be written" in capsys.readouterr().err
    (flow / "history.csv").write_text(history.replace("centre_x", "centre"))
    assert main(["overlay", str(flow), "--output", str(tmp_path / "over")]) == 2
    assert "no column 'centre_x'" in capsys.readouterr().err
    (flow / "history.csv").unlink()
    assert main(["overlay", str(flow), "--output", str(tmp_path / "over")]) == 2
    assert "no history yet" in capsys.readouterr().err
