"""The life of a run: never run twice at once, its checkpoints, its history. On going on with one see test_restart."""

from __future__ import annotations

import csv
import os
import re
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from conftest import PROBLEMS, outcome, restart, summary_of
from matplotlib.figure import Figure

import hydro.revision
from hydro.output.folder import RunFolder
from hydro.output.history import read_rows

SMALL = ("mesh.cells=[8,16]", "time.end=1.0", "output.times=[0.0,0.5,1.0]", "output.history_every=0.1")


@pytest.fixture(autouse=True)
def unpainted(monkeypatch):
    """Pictures are files without a picture: painting would take most of the time."""
    monkeypatch.setattr(Figure, "savefig", lambda self, target, **_: Path(target).write_bytes(b"picture"))


def test_a_signal_to_save_does_not_end_what_has_nothing_to_save():
    send = "lambda words: os.kill(os.getpid(), signal.SIGUSR1) or 0"
    code = f"import os, signal, hydro.cli as c; c.COMMANDS['check'] = {send}"
    ended = subprocess.run([sys.executable, "-c", f"{code}; raise SystemExit(c.main(['check']))"])
    assert ended.returncode == 0


# One process at a time


def test_a_folder_in_which_a_process_works_is_refused(run_deck, capsys):
    folder, _ = run_deck("fig4", *SMALL)
    before = outcome(folder)
    with RunFolder(folder).held():
        assert run_deck("fig4", *SMALL)[1] == 2
        assert f"process {os.getpid()} on" in capsys.readouterr().err
        assert run_deck("fig4", *SMALL, options=("--quiet", "--overwrite"))[1] == 2
        assert run_deck("fig2", "stability.f.count=2", options=("--quiet", "--overwrite"))[1] == 2
        assert restart(folder, "time.end=2") == 2
    assert outcome(folder) == before and restart(folder) == 0


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
    assert np.diff(rows["time"]) == pytest.approx(rows["dt"].to_numpy()[1:], rel=1e-9)
    assert {name: rows[f"steps_by_{name}"].iloc[-1] for name in summary["steps_by"]} == summary["steps_by"]
    assert sum(summary["steps_by"].values()) == summary["steps"]
    energy = rows["thermal_energy"] + rows["kinetic_energy"]
    assert (energy - rows["thermal_energy"][0]).to_numpy() == pytest.approx(rows["change"].to_numpy(), abs=1e-14)
    assert rows["centre_y"].to_numpy() == pytest.approx(1.0, abs=1e-9) and np.all(rows["centre_x"] <= 0.5 + 1e-9)


def test_a_history_has_what_set_the_steps(run_deck):
    limited, _ = run_deck("fig4", *SMALL, "time.dt_max=0.002", folder="limited")
    sound, _ = run_deck("fig4", *SMALL, "time.integrator=godunov", folder="sound")
    for folder, name in ((limited, "dt_max"), (sound, "sound")):
        counts = summary_of(folder)["steps_by"]
        assert max(counts, key=counts.__getitem__) == name and counts["output"] > 0
        with (folder / "history.csv").open() as file:
            assert float(list(csv.DictReader(file))[-1][f"steps_by_{name}"]) == counts[name]
