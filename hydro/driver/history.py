"""The history of a run: a row of numbers every so often, in a CSV file that a kill cannot spoil."""

from __future__ import annotations

import math
import sys
from itertools import takewhile
from pathlib import Path
from typing import Any

from hydro.driver.march import Run
from hydro.driver.trackers import Quiet
from hydro.errors import RunFailed
from hydro.observables.sets import Observables, Row, values
from hydro.output.files import write_text
from hydro.output.history import time_of, whole_lines


class History(Quiet):
    """Appends a row at the first step after each interval, or at every step if that is zero, and at the end.

    In the file of an interrupted run it takes up at `begin`, the time of the first look: what is there of rows from
    then on is dropped. RunFailed if that file has other columns.
    """

    def __init__(self, path: Path, observables: Observables, wall: Any, interval: float, begin: float):
        self.path, self.observables, self.wall, self.interval = path, observables, wall, interval
        self._header, rows = whole_lines(path)
        kept = list(takewhile(lambda row: time_of(row) < begin, rows))
        self._due = self._after(time_of(kept[-1])) if kept else 0.0
        if begin > 0.0 and not kept:
            print(f"hydro: {path}: rows before t = {begin:.6g} are lost", file=sys.stderr)
        if path.exists():
            write_text(path, "".join(f"{line}\n" for line in (self._header, *kept) if line))

    def look(self, run: Run) -> None:
        now = run.state.time
        if now < self._due and now < run.end:
            return
        row = self._row(run)
        header, values = ",".join(row), ",".join(repr(float(value)) for value in row.values())
        if self._header not in ("", header):
            raise RunFailed(f"{self.path} has other columns than this program writes; move it away")
        with self.path.open("a", encoding="utf-8") as file:
            file.write(f"{values}\n" if self._header else f"{header}\n{values}\n")
        self._header, self._due = header, self._after(now)

    def _after(self, time: float) -> float:
        """When the row after one at `time` is due."""
        return (math.floor(time / self.interval) + 1) * self.interval if self.interval > 0.0 else time

    def _row(self, run: Run) -> Row:
        state, seen = run.state, self.observables
        return {
            **values((*seen.summary, *seen.history), state, self.wall),
            "steps": run.steps,
            "dt": run.dt,
            **{f"steps_by_{name}": count for name, count in run.set_by.items()},
            **run.integrator.counts(),
            **run.reading,
            "mass": state.mass,
            **values(seen.energies, state, self.wall),
            **run.ledger.balance(state.energy),
        }
