"""The life of a run: stopped, restarted, taken further, saved by the clock and on a signal, never run twice at once."""

from __future__ import annotations

import csv
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from conftest import PROBLEMS, left_by, summary_of
from matplotlib.figure import Figure

import hydro.revision
from hydro.cli import main
from hydro.dynamics import INTEGRATORS
from hydro.gas import Grossman
from hydro.mesh import Mesh
from hydro.runs.checkpoint import read_checkpoint
from hydro.runs.folder import RunFolder
from hydro.runs.history import read_rows
from hydro.runs.observables import centre_of_mass, clusters
from hydro.runs.trackers import StopOnSignal
from hydro.state import State

SMALL = ("mesh.cells=[8,16]", "time.end=1.0", "output.times=[0.0,0.5,1.0]", "output.history_every=0.1")


def times_in(folder):
    """Times of the checkpoints."""
    return [read_checkpoint(path).time for path in RunFolder(folder).saved()]


def restart(folder, *overrides):
    """The exit code of a restart."""
    return main(["restart", str(folder), *overrides, "--quiet"])


@pytest.fixture(autouse=True)
def unpainted(monkeypatch):
    """Pictures are files without a picture: painting would take most of the time."""
    monkeypatch.setattr(Figure, "savefig", lambda self, target, **_: Path(target).write_bytes(b"picture"))


@pytest.fixture
def signalled(monkeypatch):
    """Sends this process a signal when a run has taken so many steps, once for each number of steps."""
    look = StopOnSignal.look

    def at(number: signal.Signals, *steps: int) -> None:
        waiting = set(steps)

        def look_and_send(self, run):
            if run.steps in waiting:
                waiting.remove(run.steps)
                os.kill(os.getpid(), number)
            look(self, run)

        monkeypatch.setattr(StopOnSignal, "look", look_and_send)

    return at


# Restart


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("integrator", list(INTEGRATORS))
def test_a_run_stopped_again_and_again_ends_in_the_same_bits(integrator, number, run_deck, signalled, capsys):
    words = (*SMALL, f"time.integrator={integrator}", "output.checkpoint_every=0.23")
    whole, code = run_deck("fig4", *words, folder="whole")
    assert code == 0
    steps = summary_of(whole)["steps"]
    signalled(number, 0, 1, 2, steps // 3, steps // 3 + 1, steps // 2, steps - 1)
    pieces, code = run_deck("fig4", *words, folder="pieces")
    for _ in range(6):
        assert code == 4 and not summary_of(pieces)["completed"]
        message = capsys.readouterr().err
        assert f"stopped by {number.name}" in message and f"python -m hydro restart {pieces}" in message
        code = restart(pieces)
    assert code == 4 and restart(pieces) == 0
    assert left_by(pieces) == left_by(whole)
    names = [{path.name for path in (folder / "pictures").iterdir()} for folder in (pieces, whole)]
    assert names[0] == names[1]


def test_rejected_steps_are_remembered(run_deck, signalled):
    """A strong shock, whose first steps are too long: the limit that a rejection sets holds after a restart too."""
    words = ("mesh.cells=[64,4]", "initial.right=[0.01,0,1e-9]", "scheme.riemann=hllc", "time.cfl=1.0")
    whole, code = run_deck("sod", *words, "time.end=0.02", "output.times=[0.02]", folder="whole")
    rows = read_rows(whole / "history.csv")
    assert code == 0
    signalled(signal.SIGTERM, *np.linspace(1, rows["steps"][-1], 6).astype(int).tolist()[:-1])
    pieces, code = run_deck("sod", *words, "time.end=0.02", "output.times=[0.02]", folder="pieces")
    while code == 4:
        code = restart(pieces)
    assert code == 0 and left_by(pieces) == left_by(whole)


def test_the_wall_clock_limit_stops_a_run_and_a_restart_goes_on(run_deck, capsys):
    whole, _ = run_deck("fig4", *SMALL, folder="whole")
    limited, code = run_deck("fig4", *SMALL, "time.wall_limit=1e-3", folder="limited")
    assert code == 4 and "time.wall_limit = 0.001 s" in capsys.readouterr().err
    assert restart(limited) == 4
    assert restart(limited, "time.wall_limit=inf") == 0
    assert left_by(limited) == left_by(whole)


def test_a_run_that_was_killed_before_its_first_checkpoint_begins_anew(run_deck, tmp_path, capsys):
    whole, _ = run_deck("fig4", *SMALL, folder="whole")
    (tmp_path / "begun").mkdir()
    (tmp_path / "begun" / "deck.toml").write_text((whole / "deck.toml").read_text())
    (tmp_path / "begun" / "history.csv").write_text("time,wall")
    assert restart(tmp_path / "begun") == 0
    assert "begins anew" in capsys.readouterr().err and left_by(tmp_path / "begun") == left_by(whole)


def test_a_run_that_was_killed_while_its_pictures_were_drawn_is_finished(run_deck):
    folder, _ = run_deck("fig4", *SMALL)
    before = left_by(folder)
    for name in ("summary.json", "pictures/density.png", "pictures/history.png"):
        (folder / name).unlink()
    assert restart(folder) == 0
    assert left_by(folder) == before and (folder / "pictures" / "density.png").exists()


def test_a_complete_run_says_so_and_is_left_alone(run_deck, capsys):
    folder, _ = run_deck("fig4", *SMALL)
    before = {path: path.stat().st_mtime_ns for path in folder.rglob("*") if path.name != ".lock"}
    assert restart(folder) == 0
    assert "complete at t = 1" in capsys.readouterr().err
    assert {path: path.stat().st_mtime_ns for path in folder.rglob("*") if path.name != ".lock"} == before


def test_a_complete_run_goes_further_when_its_end_is_raised(run_deck):
    whole, _ = run_deck("fig4", *SMALL, "time.end=1.5", "output.times=[0.0,0.5,1.0,1.5]", folder="whole")
    folder, _ = run_deck("fig4", *SMALL)
    assert restart(folder, "time.end=1.5", "output.times=[0.0,0.5,1.0,1.5]") == 0
    assert left_by(folder) == left_by(whole)


@pytest.mark.parametrize(
    ("overrides", "expected"),
    [
        (["gas.L=6e4", "mesh.cells=[8,8]"], ["gas.L: 60000.0 is not what the run was started with", "mesh.cells"]),
        (["wall.kind=thermal"], ["wall.kind", "wall.W", "wall.temperature"]),
        (["initial.amplitude=0.2"], ["initial.amplitude"]),
        (["time.integrator=godunov"], ["time.integrator"]),
        (["scheme.limiter=mc"], ["scheme.limiter"]),
        (["time.end=0.5", "output.times=[]"], ["time.end: 0.5 lies before the newest checkpoint, t = 1"]),
        (["time.edn=2"], ["time.edn: unknown key"]),
        (["kind=steady"], ["kind"]),
    ],
)
def test_a_restart_refuses_another_problem_by_name(overrides, expected, run_deck, capsys):
    folder, _ = run_deck("fig4", *SMALL)
    before = left_by(folder)
    assert restart(folder, *overrides) == 2
    message = capsys.readouterr().err
    assert all(part in message for part in expected) and left_by(folder) == before


def test_a_restart_may_change_how_long_how_fine_and_what_is_kept(run_deck, signalled):
    signalled(signal.SIGTERM, 20)
    folder, code = run_deck("fig4", *SMALL)
    assert code == 4
    assert (
        restart(folder, "time.tolerance=1e-3", "time.dt_max=0.02", "about.title=again", "output.times=[0.5,0.75]") == 0
    )
    summary = summary_of(folder)
    assert [row["time"] for row in summary["snapshots"]] == [0.0, 0.5, 0.75] and summary["tolerance"] == 1e-3
    assert summary["steps_by"]["dt_max"] > 0 and "again" in (folder / "deck.toml").read_text()


def test_only_an_evolution_is_continued(run_deck, tmp_path, capsys):
    folder, _ = run_deck("fig2", "stability.f.count=2", "stability.walls=['vibrating']")
    for place, expected in ((folder, "'stability'"), (tmp_path, "holds no run"), (tmp_path / "nowhere", "nowhere")):
        assert restart(place) == 2 and expected in capsys.readouterr().err
    assert not (tmp_path / ".lock").exists() and not (tmp_path / "nowhere").exists()


# Cadences


def test_checkpoints_by_the_clock_do_not_change_the_steps_and_replace_each_other(run_deck):
    whole, _ = run_deck("fig4", *SMALL, folder="whole")
    often, code = run_deck("fig4", *SMALL, "output.checkpoint_seconds=1e-6", folder="often")
    assert code == 0 and left_by(often) == left_by(whole)
    assert len(times_in(often)) == 3 + 2 and set(times_in(often)) > {0.0, 0.5, 1.0}


def test_the_newest_checkpoints_are_kept_and_those_that_were_asked_for(run_deck, signalled):
    words = (*SMALL, "output.checkpoint_every=0.08", "output.keep=3")
    folder, _ = run_deck("fig4", *words)
    expected = [0.0, 0.5, 0.8, 0.88, 0.96, 1.0]
    assert times_in(folder) == pytest.approx(expected)
    signalled(signal.SIGTERM, summary_of(folder)["steps"] // 2)
    pieces, code = run_deck("fig4", *words, folder="pieces")
    assert code == 4 and restart(pieces) == 0
    assert times_in(pieces) == pytest.approx(expected) and left_by(pieces) == left_by(folder)


def test_a_signal_saves_a_run_that_goes_on(run_deck, signalled):
    whole, _ = run_deck("fig4", *SMALL, folder="whole")
    signalled(signal.SIGUSR1, 10)
    folder, code = run_deck("fig4", *SMALL)
    assert code == 0 and left_by(folder) == left_by(whole)
    assert {int(path.name[:8]) for path in RunFolder(folder).saved()} - {
        int(path.name[:8]) for path in RunFolder(whole).saved()
    } == {11}  # the tracker for SIGUSR1 looks before the one that sent it


def test_a_signal_to_save_does_not_end_what_has_nothing_to_save():
    send = "lambda words: os.kill(os.getpid(), signal.SIGUSR1) or 0"
    code = f"import os, signal, hydro.cli as c; c.COMMANDS['check'] = {send}"
    ended = subprocess.run([sys.executable, "-c", f"{code}; raise SystemExit(c.main(['check']))"])
    assert ended.returncode == 0


# One process at a time


def test_a_folder_in_which_a_process_works_is_refused(run_deck, capsys):
    folder, _ = run_deck("fig4", *SMALL)
    before = left_by(folder)
    with RunFolder(folder).held():
        assert run_deck("fig4", *SMALL)[1] == 2
        assert f"process {os.getpid()} on" in capsys.readouterr().err
        assert run_deck("fig4", *SMALL, options=("--quiet", "--overwrite"))[1] == 2
        assert run_deck("fig2", "stability.f.count=2", options=("--quiet", "--overwrite"))[1] == 2
        assert restart(folder, "time.end=2") == 2
    assert left_by(folder) == before and restart(folder) == 0


def test_of_two_runs_started_at_once_one_is_refused(tmp_path):
    words = [
        sys.executable,
        "-m",
        "hydro",
        str(PROBLEMS / "fig4.toml"),
        *SMALL,
        "--output",
        str(tmp_path / "run"),
        "--quiet",
    ]
    both = [subprocess.Popen(words, stderr=subprocess.PIPE, text=True) for _ in range(2)]
    messages = [process.communicate(timeout=300)[1] for process in both]
    assert sorted(process.returncode for process in both) == [0, 2] and "Traceback" not in "".join(messages)
    assert summary_of(tmp_path / "run")["completed"]


def test_a_file_system_without_locks_is_said(run_deck, monkeypatch, capsys):
    def refuse(*_):
        raise OSError(38, "Function not implemented")

    monkeypatch.setattr("fcntl.flock", refuse)
    assert run_deck("fig4", *SMALL)[1] == 0
    assert "no lock (Function not implemented)" in capsys.readouterr().err


# What is kept


def test_a_checkpoint_describes_itself(run_deck):
    folder, _ = run_deck("fig4", *SMALL)
    undescribed = []
    with h5py.File(RunFolder(folder).saved()[-1]) as file:

        def visit(name, entry):
            wanted = (
                {"long_name"} if isinstance(entry, h5py.Group) or entry.dtype.kind == "O" else {"long_name", "units"}
            )
            if not wanted <= set(entry.attrs):
                undescribed.append(name)

        file.visititems(visit)
        attributes = dict(file.attrs)
    assert not undescribed
    assert attributes["deck"] == (folder / "deck.toml").read_text()
    assert attributes["hydro_version"] == hydro.__version__ and attributes["time"] == 1.0
    assert attributes.get("git_revision") == hydro.revision.git_revision()


def test_the_revision_is_that_of_the_checkout_that_holds_the_package(tmp_path, monkeypatch):
    def git(*words):
        subprocess.run(["git", "-c", "user.name=a", "-c", "user.email=a@b", *words], cwd=tmp_path, check=True)

    for name in ("hydro", "other"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "revision.py").write_text("")
    current = hydro.revision.git_revision.__wrapped__
    monkeypatch.setattr("hydro.revision.__file__", str(tmp_path / "hydro" / "revision.py"))
    monkeypatch.delenv("GIT_DIR", raising=False)
    try:
        git("init", "-q")
    except FileNotFoundError:
        pytest.skip("git is not installed")
    assert current() is None
    git("add", ".")
    git("commit", "-q", "-m", "first")
    assert re.fullmatch("[0-9a-f]{40}", current())
    (tmp_path / "hydro" / "revision.py").write_text("changed")
    assert re.fullmatch("[0-9a-f]{40}-dirty", current())
    (tmp_path / "lib" / "hydro").mkdir(parents=True)
    monkeypatch.setattr("hydro.revision.__file__", str(tmp_path / "lib" / "hydro" / "revision.py"))
    assert current() is None


def test_a_row_of_history_for_every_step(run_deck):
    folder, _ = run_deck("fig4", *SMALL, "output.history_every=0")
    rows, summary = read_rows(folder / "history.csv"), summary_of(folder)
    assert rows["steps"].tolist() == list(range(summary["steps"] + 1))
    assert np.diff(rows["time"]) == pytest.approx(rows["dt"][1:], rel=1e-9)
    assert {name: rows[f"steps_by_{name}"][-1] for name in summary["steps_by"]} == summary["steps_by"]
    assert sum(summary["steps_by"].values()) == summary["steps"]
    assert rows["thermal_energy"] + rows["kinetic_energy"] - rows["thermal_energy"][0] == pytest.approx(
        rows["change"], abs=1e-14
    )
    assert rows["centre_y"] == pytest.approx(1.0, abs=1e-9) and np.all(rows["centre_x"] <= 0.5 + 1e-9)


def test_a_history_has_what_set_the_steps(run_deck):
    limited, _ = run_deck("fig4", *SMALL, "time.dt_max=0.002", folder="limited")
    sound, _ = run_deck("fig4", *SMALL, "time.integrator=godunov", folder="sound")
    for folder, name in ((limited, "dt_max"), (sound, "sound")):
        counts = summary_of(folder)["steps_by"]
        assert max(counts, key=counts.__getitem__) == name and counts["output"] > 0
        with (folder / "history.csv").open() as file:
            assert float(list(csv.DictReader(file))[-1][f"steps_by_{name}"]) == counts[name]


@pytest.mark.parametrize("shift", range(0, 64, 7))
def test_clusters_are_counted_also_across_a_seam(shift):
    y = (np.arange(64) + 0.5) / 64
    line = 0.1 + 0.5 * np.exp(-(((y - 0.25) / 0.05) ** 2)) + 0.3 * np.exp(-(((y - 0.7) / 0.05) ** 2))
    tops = clusters(np.roll(line, shift), periodic=True)
    assert sorted((tops - shift) % 64) in ([15, 44], [16, 44], [15, 45], [16, 45])
    assert clusters(line).size == 2 and clusters(np.full(8, 0.3)).size == 0
    assert clusters(np.cos(2.0 * np.pi * y) + 1.5).size == 2  # two halves at walls, or one across a seam
    assert clusters(np.cos(2.0 * np.pi * y) + 1.5, periodic=True).size == 1


def test_the_centre_of_mass():
    mesh = Mesh.rectangle((40, 40), 2.0, 4.0)
    density = 0.1 * (1.0 + mesh.x[:, None] * (mesh.y[None, :] / 2.0))
    x, y = centre_of_mass(State.of(Grossman(0.0, 0.0), mesh, density, 1.0))
    assert (x, y) == pytest.approx((8.0 / 15.0, 16.0 / 15.0), rel=1e-3)
