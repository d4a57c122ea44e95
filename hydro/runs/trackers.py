"""Trackers: all that a run does beside advancing its state."""

from __future__ import annotations

import math
import signal
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any, TextIO

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

from hydro.errors import Stopped
from hydro.runs.march import Run, Tracker
from hydro.runs.observables import snapshot


class Quiet(Tracker):
    """Base of trackers that do not care when steps end."""

    def next_stop(self, time: float) -> float:
        return math.inf


class AtTimes:
    """Calls `act(run)` at given times, and every so often if `every` is given, exactly then."""

    def __init__(self, act: Callable[[Run], None], times: tuple[float, ...] = (), every: float | None = None):
        self.act, self.times, self.every = act, times, every
        self._last = -math.inf

    def next_stop(self, time: float) -> float:
        listed = min((at for at in self.times if at > time), default=math.inf)
        return min(listed, multiple_after(time, self.every))

    def look(self, run: Run) -> None:
        now = run.state.time
        if now in self.times or (now > 0.0 and multiple_after(self._last, self.every) == now):
            self.act(run)
        self._last = now


def multiple_after(time: float, every: float | None) -> float:
    """The first multiple of `every`, zero included, after `time`; infinite if `every` is None."""
    if every is None:
        return math.inf
    count = math.floor(max(time, 0.0) / every)
    return next(at for at in ((count + k) * every for k in range(3)) if at > time)


class History(Quiet):
    """Appends a row of observables to a CSV file, at the first step after each interval and at the end."""

    def __init__(self, path: Path, wall: Any, interval: float):
        self.path, self.wall, self.interval = path, wall, interval
        self._due = 0.0

    def look(self, run: Run) -> None:
        now = run.state.time
        if now < self._due and now < run.end:
            return
        row = self._row(run)
        with self.path.open("a", encoding="utf-8") as file:
            if file.tell() == 0:
                file.write(",".join(row) + "\n")
            file.write(",".join(repr(float(value)) for value in row.values()) + "\n")
        self._due = multiple_after(now, self.interval)

    def _row(self, run: Run) -> dict[str, float]:
        state = run.state
        kinetic = state.mesh.integral(state.kinetic_energy)
        return {
            **snapshot(state, self.wall),
            "dt": run.dt,
            "mass": state.mass,
            "kinetic_energy": kinetic,
            "thermal_energy": state.energy - kinetic,
            **run.ledger.balance(state.energy),
        }


class StopOnSignal(Quiet):
    """Stops the run, between two steps, when SIGINT or SIGTERM has come. A context manager.

    Beside the main thread, which alone gets signals, it does nothing.
    """

    def __init__(self) -> None:
        self._received: str | None = None
        self._before: dict[signal.Signals, Any] = {}

    def __enter__(self) -> StopOnSignal:
        if threading.current_thread() is not threading.main_thread():
            return self
        for number in (signal.SIGINT, signal.SIGTERM):
            self._before[number] = signal.signal(number, self._receive)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _receive(self, number: int, frame: FrameType | None) -> None:
        self._received = signal.Signals(number).name

    def look(self, run: Run) -> None:
        self.check(f"at t = {run.state.time:.6g}")

    def check(self, where: str) -> None:
        """Raise Stopped if a signal has come; `where` says how far the work has got."""
        if self._received:
            raise Stopped(f"stopped by {self._received} {where}")


class ProgressBar(Quiet):
    """A bar with rate and time left. A context manager."""

    INTERVAL = 0.2  # seconds between updates

    def __init__(self, title: str, end: float):
        columns = (
            TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(),
            TextColumn("t={task.fields[now]}  {task.fields[rate]}"), TimeRemainingColumn(),
        )  # fmt: skip
        self._progress = Progress(*columns, console=Console(stderr=True))
        self._task = self._progress.add_task(title, total=end, now="0", rate="")
        self._due = 0.0

    def __enter__(self) -> ProgressBar:
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    def look(self, run: Run) -> None:
        seconds = time.perf_counter()
        if seconds < self._due and run.state.time < run.end:
            return
        self._due = seconds + self.INTERVAL
        rate = f"{run.steps / max(run.wall_seconds, 1e-9):.0f} steps/s"
        self._progress.update(self._task, completed=run.state.time, now=f"{run.state.time:.4g}", rate=rate)


class ProgressLines(Quiet):
    """A line for every tenth of the run, for outputs that are no terminal."""

    def __init__(self, title: str, end: float, stream: TextIO = sys.stderr):
        self.title, self.end, self.stream = title, end, stream
        self._due = 0.1

    def __enter__(self) -> ProgressLines:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def look(self, run: Run) -> None:
        done = run.state.time / self.end
        if done < self._due:
            return
        left = run.wall_seconds * (1.0 / done - 1.0)
        rate = run.steps / max(run.wall_seconds, 1e-9)
        line = f"{self.title}: {done:4.0%}  t={run.state.time:.4g}  {rate:.0f} steps/s  {left:.0f} s left"
        print(line, file=self.stream, flush=True)
        self._due = math.floor(done * 10.0 + 1.0) / 10.0
