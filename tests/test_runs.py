"""Runs as a person meets them: command line, folder, failures, checkpoints."""

from __future__ import annotations

import csv
import json
import os
import re
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from conftest import PROBLEMS, summary_of

from hydro.cli import main
from hydro.deck import load
from hydro.driver.trackers import speed
from hydro.dynamics import Godunov
from hydro.dynamics.integrator import Integrator
from hydro.gas import Grossman
from hydro.output.checkpoint import read_checkpoint
from hydro.state import State, inadmissible

SMALL = ("mesh.cells=[16,32]", "time.end=3.0", "output.times=[1.0,3.0]")
EVOLUTION_KEYS = {
    "kind", "completed", "cells", "integrator", "tolerance", "time", "steps", "rejected_steps", "wall_seconds",
    "cell_updates_per_second", "peak_memory_bytes", "mass_drift", "energy_ledger", "snapshots",
}  # fmt: skip


def test_a_run_leaves_a_complete_folder(run_deck):
    folder, code = run_deck("fig4", *SMALL, "output.checkpoint_every=0.7")
    assert code == 0
    summary = summary_of(folder)
    assert set(summary) >= EVOLUTION_KEYS
    assert summary["completed"] and summary["cells"] == [16, 32] and summary["time"] == 3.0
    assert [row["time"] for row in summary["snapshots"]] == [1.0, 3.0]
    assert abs(summary["mass_drift"]) < 1e-12 and abs(summary["energy_ledger"]["residual"]) < 1e-10
    saved_at = [read_checkpoint(path).time for path in sorted(folder.glob("checkpoints/*.h5"))]
    assert saved_at == pytest.approx([0.7, 1.0, 1.4, 2.1, 2.8, 3.0], rel=1e-14)
    assert 1.0 in saved_at and 3.0 in saved_at
    pictures = {path.name for path in (folder / "pictures").iterdir()}
    assert pictures >= {"density.png", "profiles.png", "history.png"}
    assert load(folder / "deck.toml") == load(PROBLEMS / "fig4.toml", [*SMALL, "output.checkpoint_every=0.7"])


def test_history_has_a_row_for_each_interval(run_deck):
    folder, _ = run_deck("fig4", *SMALL, "output.history_every=0.5")
    with (folder / "history.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 7 and float(rows[-1]["time"]) == 3.0
    assert all(np.isfinite(float(value)) for row in rows for value in row.values())


@pytest.mark.parametrize("integrator", ["godunov", "lagrange-remap"])
def test_elastic_grains_lose_nothing(run_deck, integrator):
    """L = 0 is a number like any other, not one that is missing."""
    folder, code = run_deck("cooling", "mesh.cells=[8,8]", "gas.L=0", f"time.integrator={integrator}", "time.end=0.1")
    assert code == 0
    ledger = summary_of(folder)["energy_ledger"]
    assert ledger["collisions"] == 0.0 and abs(ledger["change"]) < 1e-14


def test_a_folder_with_a_run_is_kept_unless_told(run_deck, capsys):
    folder, _ = run_deck("cooling", "mesh.cells=[8,8]", "time.end=0.1")
    before = (folder / "summary.json").read_text()
    assert run_deck("cooling", "mesh.cells=[8,8]", "time.end=0.2")[1] == 2
    assert "--overwrite" in capsys.readouterr().err
    assert (folder / "summary.json").read_text() == before
    assert run_deck("cooling", "mesh.cells=[8,8]", "time.end=0.2", options=("--quiet", "--overwrite"))[1] == 0
    assert summary_of(folder)["time"] == 0.2


def test_progress_tells_the_speed_in_steps_and_of_grains_in_collisions(run_deck, capsys):
    words = ("gas.L=300", "gas.K=0.0255", "time.end=2.0", "output.times=[]", "output.pictures=false")
    for name, overrides, unit in (("fig4", SMALL, "steps"), ("grains_small", words, "collisions")):
        assert run_deck(name, *overrides, options=("--overwrite",))[1] == 0
        assert re.search(rf"100%  t=\d  [\d,.]+ {unit}/s  0 s left", capsys.readouterr().err)


class StepByStep(Integrator):
    """Of which only the steps count."""


@pytest.mark.parametrize(("steps", "told"), [(5, "2.5 steps/s"), (3_000_000, "1,500,000 steps/s"), (0, "0 steps/s")])
def test_a_speed_is_legible_at_any_size(steps, told):
    assert speed(SimpleNamespace(steps=steps, wall_seconds=2.0, integrator=StepByStep())) == told


def test_files_that_no_run_made_are_left_alone(run_deck, tmp_path, capsys):
    mine = tmp_path / "run" / "pictures" / "holiday.png"
    mine.parent.mkdir(parents=True)
    mine.write_text("mine")
    for options in (("--quiet",), ("--quiet", "--overwrite")):
        assert run_deck("cooling", "mesh.cells=[8,8]", "time.end=0.1", options=options)[1] == 2
    assert "pictures" in capsys.readouterr().err and mine.read_text() == "mine"


def test_a_run_does_not_replace_the_checkpoint_it_starts_from(run_deck, checkpoint, capsys):
    words = ("initial.kind=checkpoint", f"initial.path={checkpoint}")
    folder, code = run_deck("fig4", *SMALL, *words, options=("--quiet", "--overwrite"))
    assert code == 2 and "initial.path" in capsys.readouterr().err
    assert checkpoint.exists() and checkpoint.is_relative_to(folder)


def test_a_start_that_fails_leaves_no_folder(run_deck):
    folder, code = run_deck("fig4", "initial.kind=checkpoint", "initial.path=nowhere.h5")
    assert code == 2 and not folder.exists()


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["nothing.toml"], "nothing.toml"),
        (["gas.f=2"], "gas.f"),
        (["output.checkpoint_every=1e-20"], "output.checkpoint_every"),
        (["output.history_every=1e-310"], "output.history_every"),
        (["time.integrator=godunof"], "godunov"),
        (["wall.kind=thermal", "wall.W=1"], "wall.W"),
        (["initial.kind=checkpoint", "initial.path=nowhere.h5"], "nowhere.h5"),
    ],
)
def test_bad_decks_end_with_exit_code_2(words, expected, tmp_path, capsys):
    deck = words if words[0].endswith(".toml") else [str(PROBLEMS / "fig4.toml"), *words]
    assert main([*deck, "--output", str(tmp_path / "run")]) == 2
    message = capsys.readouterr().err
    assert expected in message and "Traceback" not in message


def test_check_prints_deck_scales_and_warnings(capsys):
    assert main(["check", str(PROBLEMS / "fig4.toml"), "gas.mu=0.1", "initial.amplitude=0.9"]) == 0
    printed = capsys.readouterr().out
    for part in ("aspect_ratio = 2.0", "sound time", "conduction time", "time step", "run time"):
        assert part in printed
    for warned in ("1 - r^2", "thermal length", "Mach"):
        assert any(line.startswith("# warning") and warned in line for line in printed.splitlines())


def test_check_knows_that_a_stronger_wall_is_hotter(capsys):
    """kappa ~ T^(1/2) and q ~ W T^(1/2): the wall's temperature is proportional to W."""
    temperatures = []
    for W in (114.0, 228.0):
        main(["check", str(PROBLEMS / "fig4.toml"), f"wall.W={W}"])
        (line,) = (line for line in capsys.readouterr().out.splitlines() if "wall temperature" in line)
        temperatures.append(float(line.split()[3]))
    assert temperatures == pytest.approx([1.0, 2.0], rel=0.02)


def test_check_of_a_good_deck_does_not_warn(capsys):
    """Grains so elastic that the wall is slow against them."""
    overrides = ["mesh.cells=[128,256]", "gas.K=1e-4", "gas.tau=inf"]
    assert main(["check", str(PROBLEMS / "fig4.toml"), *overrides]) == 0
    assert "warning" not in capsys.readouterr().out


def test_a_failing_run_saves_its_last_good_state(tmp_path, capsys, monkeypatch):
    """Two streams that leave a vacuum behind: no step of second order alone can succeed for long."""
    monkeypatch.setattr(Godunov, "_careful_flow", Godunov._flow)
    deck = [str(PROBLEMS / "sod.toml"), "initial.left=[0.4,-3e3,1e-3]", "initial.right=[0.4,3e3,1e-3]"]
    folder = tmp_path / "vacuum"
    assert main([*deck, "mesh.cells=[50,4]", "--output", str(folder), "--quiet"]) == 3
    message = capsys.readouterr().err
    assert "cell (" in message and "n = " in message and "Traceback" not in message
    summary = summary_of(folder)
    assert not summary["completed"] and summary["rejected_steps"] > 0
    last = read_checkpoint(sorted(folder.glob("checkpoints/*.h5"))[-1])
    assert last.time == summary["time"]
    assert not inadmissible(State(Grossman(L=0.0, K=0.0), last.mesh, last.conserved)).any()


def test_a_signal_stops_a_run_between_steps(tmp_path):
    folder = tmp_path / "run"
    words = [sys.executable, "-m", "hydro", str(PROBLEMS / "fig4.toml"), "--output", str(folder), "--quiet"]
    process = subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 120.0
    while not (folder / "history.csv").exists() and time.monotonic() < deadline:
        time.sleep(0.1)
    process.send_signal(signal.SIGTERM)
    message = process.communicate(timeout=60)[1]
    assert process.returncode == 4 and "SIGTERM" in message and "Traceback" not in message
    summary = summary_of(folder)
    assert not summary["completed"] and 0.0 < summary["time"] < 1290.0
    assert read_checkpoint(sorted(folder.glob("checkpoints/*.h5"))[-1]).time == summary["time"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("deck", ["branches", "fig1"])
def test_a_signal_keeps_the_points_of_a_branch_and_the_rows_of_a_curve(deck, number, tmp_path):
    folder = tmp_path / "run"
    words = [sys.executable, "-m", "hydro", str(PROBLEMS / f"{deck}.toml"), "--output", str(folder), "--quiet"]
    process = subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 120.0
    begun = folder / ("points.csv" if deck == "branches" else "deck.toml")
    while not begun.exists() and time.monotonic() < deadline:
        time.sleep(0.1)
    time.sleep(1.0)
    process.send_signal(number)
    message = process.communicate(timeout=60)[1]
    assert process.returncode == 4 and number.name in message and "Traceback" not in message
    summary = summary_of(folder)
    assert summary["completed"] is False and len(summary["points" if deck == "branches" else "rows"]) > 0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_before_there_is_anything_to_save(number, tmp_path):
    code = f"import os, hydro.cli as c; c.COMMANDS['check'] = lambda words: os.kill(os.getpid(), {int(number)})"
    words = [sys.executable, "-c", f"{code}; raise SystemExit(c.main(['check']))"]
    ended = subprocess.run(words, capture_output=True, text=True)
    assert ended.returncode == 4 and "stopped by a signal" in ended.stderr and "Traceback" not in ended.stderr


@pytest.mark.parametrize("deck", ["fig2", "fig3a", "branches", "fig4"])
def test_a_folder_that_cannot_be_written_is_refused_at_once(deck, tmp_path, monkeypatch, capsys):
    (tmp_path / "file").write_text("mine")
    assert main([str(PROBLEMS / f"{deck}.toml"), "--output", str(tmp_path / "file" / "run")]) == 2
    assert "is no folder to write into" in capsys.readouterr().err
    monkeypatch.setattr("os.access", lambda *_: False)
    assert main([str(PROBLEMS / f"{deck}.toml"), "--output", str(tmp_path / "run")]) == 2


def test_without_a_deck_only_the_deck_is_asked_for(capsys):
    with pytest.raises(SystemExit) as ended:
        main([])
    message = capsys.readouterr().err
    assert ended.value.code == 2 and "required: DECK.toml" in message and "DECK.toml, section" not in message


def test_help_is_quick_and_imports_nothing_heavy():
    code = "import sys, hydro.cli as c\ntry: c.main(['--help'])\nexcept SystemExit: pass\nprint(sorted(sys.modules))"
    printed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert "DECK.toml" in printed
    assert not {"'numpy'", "'numba'", "'pydantic'", "'matplotlib'", "'rich'"} & set(printed.replace(",", "").split())


@pytest.fixture
def checkpoint(run_deck):
    folder, _ = run_deck("fig4", *SMALL, "time.integrator=godunov")
    return sorted(folder.glob("checkpoints/*.h5"))[-1]


def test_going_on_from_a_checkpoint_gives_the_state_of_one_run(run_deck, checkpoint):
    """Split in two, the run takes the same steps; only the first guess for the wall's temperature is new."""
    source = ("initial.kind=checkpoint", f"initial.path={checkpoint}")
    common = (*SMALL[:1], "time.integrator=godunov")
    rest, _ = run_deck("fig4", *common, *source, "time.end=1.0", "output.times=[1.0]", folder="rest")
    whole, _ = run_deck("fig4", *common, "time.end=4.0", "output.times=[1.0,3.0,4.0]", folder="whole")
    ends = [read_checkpoint(sorted(folder.glob("checkpoints/*.h5"))[-1]).conserved for folder in (rest, whole)]
    np.testing.assert_allclose(*ends, rtol=1e-10, atol=1e-14)


def test_a_checkpoint_starts_a_run_on_another_mesh_with_a_perturbation(run_deck, checkpoint):
    words = (
        "initial.kind=checkpoint", f"initial.path={checkpoint}", "mesh.cells=[24,40]", "mesh.stretch=3.0",
        'initial.perturbation={ kind = "cosine", amplitude = 0.01, wave = 1 }', "time.end=0.01", "output.times=[0.0]",
    )  # fmt: skip
    folder, code = run_deck("fig4", *words, folder="other")
    assert code == 0
    first = read_checkpoint(sorted(folder.glob("checkpoints/*.h5"))[0])
    before = read_checkpoint(checkpoint)
    assert first.conserved.shape == (4, 24, 40)
    assert first.mesh.integral(first.conserved[0]) == pytest.approx(
        before.mesh.integral(before.conserved[0]), rel=1e-13
    )
    line = first.conserved[0].sum(axis=0)
    assert line[0] > line[-1] * 1.01  # the start is symmetric in y, the perturbation is not


def damage(path, kind):
    if kind == "cut":
        os.truncate(path, path.stat().st_size // 2)
    elif kind == "other":
        path.write_bytes(b"not an HDF5 file")
    else:
        with h5py.File(path, "r+") as file:
            if kind == "missing":
                del file["energy"]
            elif kind == "shape":
                del file["density"]
                file["density"] = np.ones((3, 3))
            elif kind == "version":
                file.attrs["format_version"] = 99


@pytest.mark.parametrize("kind", ["cut", "other", "missing", "shape", "version"])
def test_a_damaged_checkpoint_is_refused_by_name(kind, checkpoint, run_deck, capsys):
    damage(checkpoint, kind)
    _, code = run_deck("fig4", "initial.kind=checkpoint", f"initial.path={checkpoint}", folder="from_damaged")
    message = capsys.readouterr().err
    assert code == 2 and checkpoint.name in message and "Traceback" not in message


def test_json_of_the_summary_has_no_nan(run_deck):
    folder, _ = run_deck("cooling", "mesh.cells=[8,8]", "time.end=0.1")

    def refuse(constant):
        raise AssertionError(constant)

    json.loads((folder / "summary.json").read_text(), parse_constant=refuse)
