"""Keeping frames of a movie while a run goes on."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

from hydro.driver.march import Run
from hydro.driver.trackers import Quiet, multiple_after
from hydro.movies.frames import forget_after, frame_time, frames, write_frame
from hydro.state import State


class Frames(Quiet):
    """Keeps a frame of the first step after each interval, and of the last: of the state that `seen` gives of a run.

    Goes on after the frames that the folder holds; those later than `begin`, the time of the first look, are removed.
    """

    def __init__(self, folder: Path, interval: float, begin: float, seen: Callable[[Run], State]):
        self.folder, self.interval, self.seen = folder, interval, seen
        folder.mkdir(exist_ok=True)
        forget_after(folder, begin)
        self._due = multiple_after(max(map(frame_time, frames(folder)), default=-math.inf), interval)

    def look(self, run: Run) -> None:
        now = run.state.time
        if now >= self._due or now >= run.end:
            write_frame(self.folder, self.seen(run))
            self._due = multiple_after(now, self.interval)
