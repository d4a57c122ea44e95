"""Going on with a run: the same bits as without the interruption, whatever interrupted it."""

from __future__ import annotations

import itertools
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
from conftest import PROBLEMS, differences, outcome, restart, summary_of
from zygote import draw_nothing

from hydro.cli import main
from hydro.driver import trackers
from hydro.driver.history import History
from hydro.dynamics import Godunov
from hydro.movies.frames import frames
from hydro.output.checkpoint import read_checkpoint
from hydro.output.history import read_rows

INTEGRATORS = ("godunov", "lagrange-remap")
SMALL = (
    "mesh.cells=[8,16]", "time.end=2.0", "output.times=[0.7,2.0]", "output.checkpoint_every=0.45",
    "output.history_every=0.05",
)  # fmt: skip
FRAMES = ("output.movie=true", "output.movie_every=0.1")
STOPPED_AT = 17  # steps: between two checkpoints
KILLS = 50
SHORT = ("time.end=1.0", "output.times=[0.3,1.0]", "output.checkpoint_every=0.2")


def deck(integrator):
    return [str(PROBLEMS / "fig4.toml"), *SMALL, f"time.integrator={integrator}"]


@pytest.fixture(autouse=True)
def _no_pictures(monkeypatch):
    draw_nothing(monkeypatch.setattr)


@pytest.fixture
def run(tmp_path):
    """Runs a small deck: (folder, exit code)."""

    def run(integrator, *overrides, name="run"):
        folder = tmp_path / name
        return folder, main([*deck(integrator), *overrides, "--output", str(folder), "--quiet"])

    return run


def at_steps(monkeypatch, steps, act):
    """Call `act()` as the history looks at a run after these steps, once for each."""
    look, waiting = History.look, set(steps)

    def look_and_act(self, run):
        look(self, run)
        if run.steps in waiting:
            waiting.remove(run.steps)
            act()

    monkeypatch.setattr(History, "look", look_and_act)


def send(number):
    return lambda: os.kill(os.getpid(), number)


class Clock:
    """A clock that can be put forward."""

    def __init__(self):
        self.ahead = 0.0

    def monotonic(self):
        return time.monotonic() + self.ahead

    def forward(self):
        self.ahead += 1e6


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(trackers, "time", clock)
    return clock


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_run_stopped_again_and_again_ends_in_the_same_bits(number, integrator, run, monkeypatch, capsys):
    undisturbed, _ = run(integrator, *FRAMES, name="undisturbed")
    steps = summary_of(undisturbed)["steps"]
    stops = (0, 1, 2, steps // 3, steps // 3 + 1, steps // 2, steps - 1)
    at_steps(monkeypatch, stops, send(number))
    folder, code = run(integrator, *FRAMES)
    for stop in stops:
        message = capsys.readouterr().err
        assert code == 4 and f"stopped by {number.name}" in message and f"python -m hydro restart {folder}" in message
        assert not summary_of(folder)["completed"] and summary_of(folder)["steps"] == stop
        code = restart(folder)
    assert code == 0 and not differences(folder, outcome(undisturbed))
    assert len(frames(folder / "frames")) > 10


@pytest.mark.parametrize("trouble", ["rejected_steps", "first_order_cells"])
def test_troubles_are_remembered(run_deck, monkeypatch, trouble):
    """Cold streams that part: cells fall back to first order, and by second order alone steps are too long. How many,
    and the limit that a rejection sets, hold after a restart too.
    """
    if trouble == "rejected_steps":
        monkeypatch.setattr(Godunov, "_careful_flow", Godunov._flow)
    streams = ("initial.left=[0.5,-5,1e-6]", "initial.right=[0.5,5,1e-6]")
    words = ("mesh.cells=[64,4]", *streams, "scheme.riemann=hllc", "time.cfl=1.0")
    whole, code = run_deck("sod", *words, "time.end=0.02", "output.times=[0.02]", folder="whole")
    rows = read_rows(whole / "history.csv")
    assert code == 0 and summary_of(whole)[trouble] > 100
    stops = np.linspace(1, rows["steps"].iloc[-1], 6).astype(int).tolist()[:-1]
    at_steps(monkeypatch, stops, send(signal.SIGTERM))
    pieces, code = run_deck("sod", *words, "time.end=0.02", "output.times=[0.02]", folder="pieces")
    while code == 4:
        code = restart(pieces)
    assert code == 0 and not differences(pieces, outcome(whole))


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_run_stopped_by_its_limit_of_time_goes_on_to_the_same_bits(integrator, run, clock, monkeypatch, capsys):
    expected = outcome(run(integrator, name="undisturbed")[0])
    at_steps(monkeypatch, [STOPPED_AT], clock.forward)
    folder, code = run(integrator, "time.wall_limit=1e5")
    assert code == 4 and "time.wall_limit = 100000 s" in capsys.readouterr().err
    assert summary_of(folder)["steps"] == STOPPED_AT
    assert restart(folder) == 0  # for another 1e5 seconds
    assert not differences(folder, expected)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_signal_to_save_changes_nothing(integrator, run, monkeypatch):
    expected = outcome(run(integrator, name="undisturbed")[0])
    at_steps(monkeypatch, [STOPPED_AT], send(signal.SIGUSR1))
    folder, code = run(integrator)
    assert code == 0 and not differences(folder, expected)
    saved = {path.name for path in folder.glob("checkpoints/*.h5")}
    extra = saved - {path.name for path in folder.parent.glob("undisturbed/checkpoints/*.h5")}
    assert [name.partition("_")[0] for name in extra] == [f"{STOPPED_AT:08d}"]


def test_a_signal_at_the_last_step_leaves_only_the_closing_to_do(run, monkeypatch):
    undisturbed, _ = run("godunov", name="undisturbed")
    expected = outcome(undisturbed)
    at_steps(monkeypatch, [summary_of(undisturbed)["steps"]], send(signal.SIGTERM))
    folder, code = run("godunov")
    assert code == 4 and summary_of(folder)["time"] == 2.0
    assert restart(folder) == 0 and not differences(folder, expected)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_frames_later_than_the_checkpoint_are_taken_again(integrator, run):
    """As after a kill: of all that is later than one of the checkpoints only that is kept which cannot be known."""
    folder, _ = run(integrator, *FRAMES)
    expected = outcome(folder)
    saved = sorted(folder.glob("checkpoints/*.h5"))
    back_to = read_checkpoint(saved[2]).time
    for path in saved[3:]:
        path.unlink()
    earlier = {path: path.stat().st_mtime_ns for path in frames(folder / "frames") if float(path.stem[1:]) < back_to}
    late = folder / "frames" / f"t{back_to + 1e-3!r}.h5"
    late.write_bytes(b"")
    assert restart(folder) == 0 and not differences(folder, expected)
    assert earlier and {path: path.stat().st_mtime_ns for path in earlier} == earlier
    assert not late.exists()


def test_a_run_that_was_killed_before_its_first_checkpoint_begins_anew(run, tmp_path, capsys):
    whole, _ = run("lagrange-remap")
    begun = tmp_path / "begun"
    begun.mkdir()
    (begun / "deck.toml").write_text((whole / "deck.toml").read_text())
    (begun / "history.csv").write_text("time,wall")
    assert restart(begun) == 0
    assert "begins anew" in capsys.readouterr().err and not differences(begun, outcome(whole))


def test_a_run_that_was_killed_while_its_pictures_were_drawn_is_finished(run):
    folder, _ = run("lagrange-remap")
    expected = outcome(folder)
    (folder / "summary.json").unlink()
    assert restart(folder) == 0 and not differences(folder, expected)


def test_a_complete_run_says_so_and_is_left_alone(run, capsys):
    folder, _ = run("lagrange-remap")
    before = {path: path.stat().st_mtime_ns for path in folder.rglob("*") if path.name != ".lock"}
    assert restart(folder) == 0
    assert "complete at t = 2" in capsys.readouterr().err
    assert {path: path.stat().st_mtime_ns for path in folder.rglob("*") if path.name != ".lock"} == before


def test_a_complete_run_goes_further_when_its_end_is_raised(run):
    further = ("time.end=2.5", "output.times=[0.7,2.0,2.5]")
    whole, _ = run("lagrange-remap", *further, name="whole")
    folder, _ = run("lagrange-remap")
    assert restart(folder, *further) == 0 and not differences(folder, outcome(whole))


@pytest.mark.parametrize(
    ("overrides", "expected"),
    [
        (["gas.f=0.03"], ["gas.f: 0.03 is not what the run was started with"]),
        (["gas.L=6e4", "mesh.cells=[8,8]"], ["gas.L: 60000.0 is not what the run was started with", "mesh.cells: "]),
        (["wall.kind=thermal"], ["wall.kind: ", "wall.W: ", "wall.temperature: "]),
        (["initial.amplitude=0.2"], ["initial.amplitude: "]),
        (["time.integrator=godunov"], ["time.integrator: "]),
        (["scheme.limiter=mc"], ["scheme.limiter: "]),
        (["time.end=0.5", "output.times=[]"], ["time.end: 0.5 lies before the newest checkpoint, t = 2"]),
        (["time.edn=2"], ["time.edn: unknown key"]),
        (["kind=steady"], ["time: unknown key", "initial: unknown key"]),
    ],
)
def test_a_restart_refuses_another_problem_by_name(overrides, expected, run, capsys):
    folder, _ = run("lagrange-remap")
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file() and path.name != ".lock"}
    assert restart(folder, *overrides) == 2
    message = capsys.readouterr().err
    assert all(part in message for part in expected)
    assert {path: path.read_bytes() for path in before} == before


def test_a_restart_may_change_how_long_how_fine_and_what_is_kept(run, monkeypatch):
    at_steps(monkeypatch, [STOPPED_AT], send(signal.SIGTERM))
    folder, code = run("lagrange-remap")
    assert code == 4
    finer = ("time.tolerance=1e-3", "time.dt_max=0.02", "about.title=again", "output.times=[0.7,0.75,2.0]")
    assert restart(folder, *finer) == 0
    summary = summary_of(folder)
    assert [row["time"] for row in summary["snapshots"]] == [0.7, 0.75, 2.0] and summary["tolerance"] == 1e-3
    assert summary["steps_by"]["dt_max"] > 0 and "again" in (folder / "deck.toml").read_text()


def test_only_a_run_in_time_is_continued(run_deck, tmp_path, capsys):
    folder, _ = run_deck("fig2", "stability.f.count=2", "stability.walls=['vibrating']")
    for place, expected in ((folder, "'stability'"), (tmp_path, "holds no run"), (tmp_path / "nowhere", "nowhere")):
        assert restart(place) == 2 and expected in capsys.readouterr().err
    assert not (tmp_path / ".lock").exists() and not (tmp_path / "nowhere").exists()
    with pytest.raises(SystemExit) as ended:  # by the parser
        main(["restart"])
    assert ended.value.code == 2


# What is kept


def times_in(page):
    return [float(at.get("Value")) for at in ElementTree.parse(page).iter("Time")]


def check_series(folder):
    """The XDMF page names the checkpoints that are there, with their times."""
    saved = sorted(folder.glob("checkpoints/*.h5"))
    named = {item.text.partition(":")[0] for item in ElementTree.parse(folder / "checkpoints.xdmf").iter("DataItem")}
    assert named == {f"checkpoints/{path.name}" for path in saved}
    assert times_in(folder / "checkpoints.xdmf") == [read_checkpoint(path).time for path in saved]


def times_saved(folder):
    return [float(path.stem.partition("_t")[2]) for path in sorted(folder.glob("checkpoints/*.h5"))]


@pytest.mark.parametrize(
    ("keep", "kept"), [("1", [0.7, 1.8, 2.0]), ("3", [0.7, 0.9, 1.35, 1.8, 2.0]), ("9", [0.45, 0.7, 0.9, 1.35, 1.8, 2])]
)
def test_the_newest_are_kept_beside_those_asked_for(keep, kept, run, monkeypatch):
    folder, _ = run("godunov", f"output.keep={keep}")
    assert times_saved(folder) == kept
    check_series(folder)
    at_steps(monkeypatch, [STOPPED_AT], send(signal.SIGTERM))
    stopped, _ = run("godunov", f"output.keep={keep}", name="stopped")
    check_series(stopped)
    assert restart(stopped) == 0
    assert len(times_saved(stopped)) <= len(kept) + (keep == "9")  # there is room for that of the signal
    check_series(stopped)


def test_checkpoints_by_wall_clock_replace_each_other(run, clock, monkeypatch):
    """An hour passes between any two steps."""
    look = History.look

    def look_for_long(self, run):
        look(self, run)
        clock.forward()

    words = ("output.checkpoint_every=10.0", "output.checkpoint_seconds=3600")
    expected = outcome(run("godunov", *words, name="undisturbed")[0])
    monkeypatch.setattr(History, "look", look_for_long)
    folder, _ = run("godunov", *words)
    assert not differences(folder, expected)
    steps = [int(path.name.partition("_")[0]) for path in sorted(folder.glob("checkpoints/*.h5"))]
    last = summary_of(folder)["steps"]
    assert len(steps) == 4 and steps[1:] == [last - 2, last - 1, last]
    check_series(folder)


def test_a_kill_between_a_checkpoint_and_its_clean_up_leaves_nothing_behind(run, monkeypatch):
    """The checkpoint is written; what it replaces is not yet removed, nor does the page know of it."""

    class Killed(BaseException):
        pass

    undisturbed, _ = run("godunov", "output.keep=1", name="undisturbed")
    write = "hydro.driver.keeper.write_checkpoint"
    from hydro.output.checkpoint import write_checkpoint

    def write_and_die(path, saved):
        write_checkpoint(path, saved)
        if "t1.35" in path.name:
            raise Killed

    monkeypatch.setattr(write, write_and_die)
    with pytest.raises(Killed):
        run("godunov", "output.keep=1")
    monkeypatch.setattr(write, write_checkpoint)
    folder = undisturbed.parent / "run"
    assert times_saved(folder) == [0.7, 0.9, 1.35]
    assert restart(folder) == 0
    assert times_saved(folder) == times_saved(undisturbed) and not differences(folder, outcome(undisturbed))


# kill -9


class Zygote:
    """See zygote.py."""

    def __init__(self, *warm_up):
        self.process = subprocess.Popen(
            [sys.executable, Path(__file__).with_name("zygote.py")],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            env={**os.environ, "NUMBA_THREADING_LAYER": "workqueue"},  # OpenMP forbids to fork
        )  # fmt: skip
        self._say(warm_up)

    def start(self, words, errors):
        """The id of a new process that runs a command."""
        return self._ask([words, str(errors)])

    def wait(self, child):
        """Its exit code, when it has ended."""
        return self._ask(child)

    def close(self):
        self.process.stdin.close()
        self.process.wait(60)

    def _say(self, what):
        print(json.dumps(what), file=self.process.stdin, flush=True)

    def _ask(self, what):
        self._say(what)
        return int(self.process.stdout.readline())


@pytest.fixture(scope="module")
def zygote():
    zygote = Zygote(*map(deck, INTEGRATORS))
    yield zygote
    zygote.close()


@pytest.fixture
def memory(tmp_path):
    """A folder in memory, where there is one: a kill does not care for disks, and they are slow."""
    place = "/dev/shm" if os.access("/dev/shm", os.W_OK) else tmp_path
    with tempfile.TemporaryDirectory(dir=place) as folder:
        yield Path(folder)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_run_killed_at_random_moments_ends_in_the_same_bits(integrator, zygote, memory):
    """25 kills for each integrator: in one run until it ends nevertheless, then in the next."""
    chance, errors = random.Random(f"kill {integrator}"), memory / "errors"
    words = [*deck(integrator), *SHORT, "output.keep=2", *FRAMES, "--quiet"]
    for name in ("first", "undisturbed"):  # the first one loads, or compiles, what is missing
        started = time.monotonic()
        assert zygote.wait(zygote.start([*words, "--output", str(memory / name)], errors)) == 0
        length = time.monotonic() - started
    expected = outcome(memory / "undisturbed")
    killed, restarts = 0, 0
    for number in itertools.count():
        folder = memory / f"run{number}"
        command = [*words, "--output", str(folder)]
        while True:
            child = zygote.start(command, errors)
            if killed < KILLS // 2:
                time.sleep(chance.uniform(0.0, length))
                os.kill(child, signal.SIGKILL)
            code = zygote.wait(child)
            if code != -signal.SIGKILL:
                break
            killed += 1
            if (folder / "deck.toml").exists():
                command, restarts = ["restart", str(folder), "--quiet"], restarts + 1
        assert code == 0, errors.read_text()
        assert not differences(folder, expected)
        check_series(folder)
        assert times_saved(folder) == times_saved(memory / "undisturbed")
        assert not list(folder.rglob(".partial-*"))
        if killed >= KILLS // 2:
            break
    assert restarts > KILLS // 4  # others fell before the run had begun
