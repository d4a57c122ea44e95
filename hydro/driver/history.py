"""The history of a run: a row of numbers every so often, in a CSV file that a kill cannot spoil."""

from __future__ import annotations

import math
import sys
from itertools import takewhile
from pathlib import Path
from typing import Any

import numpy as np

from hydro.driver.march import Run
from hydro.driver.trackers import Quiet
from hydro.errors import RunFailed
from hydro.observables.clustering import arrangement, snapshot
from hydro.output.files import write_text


class History(Quiet):
    """Appends a row at the first step after each interval, or at every step if that is zero, and at the end.

    In the file of an interrupted run it takes up at `begin`, the time of the first look: what is there of rows from
    then on is dropped. RunFailed if that file has other columns.
    """

    def __init__(self, path: Path, wall: Any, interval: float, begin: float):
        self.path, self.wall, self.interval = path, wall, interval
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

    def _row(self, run: Run) -> dict[str, float]:
        state = run.state
        kinetic = state.mesh.integral(state.kinetic_energy)
        return {
            **snapshot(state, self.wall),
            **arrangement(state),
            "steps": run.steps,
            "dt": run.dt,
            **{f"steps_by_{name}": count for name, count in run.set_by.items()},
            "mass": state.mass,
            "kinetic_energy": kinetic,
            "thermal_energy": state.energy - kinetic,
            **run.ledger.balance(state.energy),
        }


def read_rows(path: Path) -> np.ndarray:
    """The rows of a history file as a structured array, a field per column; an unfinished row is left out."""
    header, rows = whole_lines(path)
    columns = np.dtype([(name, float) for name in header.split(",") if name])
    return np.array([tuple(map(float, row.split(","))) for row in rows], columns)


def whole_lines(path: Path) -> tuple[str, list[str]]:
    """Header and rows of a history file, up to the first row that is damaged; nothing if there is no file."""
    text = path.read_text(encoding="utf-8", errors="replace") if path.exists() else ""
    header, *rows = text.split("\n")[:-1] or [""]
    return header, list(takewhile(lambda row: is_whole(row, header.count(",")), rows))


def is_whole(row: str, commas: int) -> bool:
    """Whether a row has a number in every column."""
    try:
        return len([float(value) for value in row.split(",")]) == commas + 1
    except ValueError:
        return False


def time_of(row: str) -> float:
    """The first column."""
    return float(row.partition(",")[0])
