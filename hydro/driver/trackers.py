"""Trackers: all that a run does beside advancing its state."""

from __future__ import annotations

import math
import signal
import threading
import time
from collections.abc import Callable
from types import FrameType
from typing import Any, ClassVar, Self

from hydro.driver.march import Run, Tracker
from hydro.errors import Stopped
from hydro.progress import Progress, legible


class Quiet(Tracker):
    """Base of trackers that do not care when steps end."""

    def next_stop(self, time: float) -> float:
        return math.inf


class EachStep(Quiet):
    """Calls `act(run)` before the first step and after each."""

    def __init__(self, act: Callable[[Run], None]):
        self.act = act

    def look(self, run: Run) -> None:
        self.act(run)


class AtTimes:
    """Calls `act(run)` at given times, and every so often if `every` is given, exactly then, but not up to `done`."""

    def __init__(
        self,
        act: Callable[[Run], None],
        times: tuple[float, ...] = (),
        every: float | None = None,
        done: float = -math.inf,
    ):
        self.act, self.times, self.every = act, times, every
        self._last = done

    def next_stop(self, time: float) -> float:
        listed = min((at for at in self.times if at > time), default=math.inf)
        return min(listed, multiple_after(time, self.every))

    def look(self, run: Run) -> None:
        now = run.state.time
        multiple = now > 0.0 and multiple_after(self._last, self.every) == now
        if now > self._last and (now in self.times or multiple):
            self.act(run)
        self._last = now


class AtReadings(Quiet):
    """Calls `act(run)` after the first step by which the clock of a run has reached each of the given readings."""

    def __init__(self, act: Callable[[Run], None], readings: tuple[float, ...]):
        self.act, self.readings = act, readings
        self._last = math.inf

    def look(self, run: Run) -> None:
        (now,) = run.reading.values() or (0.0,)
        if any(self._last < reading <= now for reading in self.readings):
            self.act(run)
        self._last = now


def multiple_after(time: float, every: float | None) -> float:
    """The first multiple of `every`, zero included, after `time`; infinite if `every` is None."""
    if every is None:
        return math.inf
    count = math.floor(max(time, 0.0) / every)
    return next(at for at in ((count + k) * every for k in range(3)) if at > time)


class Every(Quiet):
    """Calls `act(run)` at the first look after every so many seconds of wall clock."""

    def __init__(self, act: Callable[[Run], None], seconds: float):
        self.act, self.seconds = act, seconds
        self._last = time.monotonic()

    def look(self, run: Run) -> None:
        if time.monotonic() - self._last >= self.seconds:
            self.act(run)
            self._last = time.monotonic()


class WallLimit(Quiet):
    """Stops the run, between two steps, so many seconds of wall clock from now."""

    def __init__(self, seconds: float):
        self.seconds = seconds
        self._until = time.monotonic() + seconds

    def look(self, run: Run) -> None:
        if time.monotonic() >= self._until:
            raise Stopped(f"stopped by time.wall_limit = {self.seconds:g} s at t = {run.state.time:.6g}")


class OnSignal(Quiet):
    """Base of trackers that note signals, to act between two steps. A context manager.

    Beside the main thread, which alone gets signals, it does nothing.
    """

    signals: ClassVar[tuple[signal.Signals, ...]]

    def __init__(self) -> None:
        self._received: str | None = None
        self._before: dict[signal.Signals, Any] = {}

    def __enter__(self) -> Self:
        if threading.current_thread() is not threading.main_thread():
            return self
        for number in self.signals:
            self._before[number] = signal.signal(number, self._receive)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _receive(self, number: int, frame: FrameType | None) -> None:
        self._received = signal.Signals(number).name


class SaveOnSignal(OnSignal):
    """Calls `act(run)` when SIGUSR1 has come."""

    signals = (signal.SIGUSR1,)

    def __init__(self, act: Callable[[Run], None]):
        super().__init__()
        self.act = act

    def look(self, run: Run) -> None:
        if self._received:
            self._received = None
            self.act(run)


class StopOnSignal(OnSignal):
    """Stops the run when SIGINT or SIGTERM has come."""

    signals = (signal.SIGINT, signal.SIGTERM)

    def look(self, run: Run) -> None:
        self.check(f"at t = {run.state.time:.6g}")

    def check(self, where: str) -> None:
        """Raise Stopped if a signal has come; `where` says how far the work has got."""
        if self._received:
            raise Stopped(f"stopped by {self._received} {where}")


def speed(run: Run) -> str:
    """The mean speed of a run so far, with its unit."""
    work, unit = run.integrator.work(run.steps)
    return f"{legible(work / max(run.wall_seconds, 1e-9))} {unit}/s"


class ShowProgress(Quiet):
    """Shows how far a run has got."""

    def __init__(self, shown: Progress):
        self.shown = shown

    def look(self, run: Run) -> None:
        self.shown.show(run.state.time, f"t={run.state.time:.4g}  {speed(run)}")
