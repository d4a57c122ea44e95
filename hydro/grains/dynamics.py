"""Grains in a box, advanced in time."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from hydro.errors import RunFailed
from hydro.grains import events
from hydro.grains.events import CLOCK, COUNTS, MOTION, PROSPECT, SUMS, Arena, Grains
from hydro.grains.queue import FINEST, aligned, calendar
from hydro.grains.random import seeded

EPOCH = 0.25  # times are counted from the last multiple of this: small numbers have fine digits
BUDGET = 1_000_000  # events between looks at the clock
PROGRESS = 1e-13  # of the clock in as many events, if grains do not collide without end
CELL = 1.01  # smallest width of a cell, in diameters
CELLS_PER_GRAIN = 40.0  # at most
COLUMNS = ("x", "y", "vx", "vy", "time")  # of what is kept as `motion`


def arena(
    diameter: float,
    restitution: float,
    length_y: float,
    number: int,
    periodic: tuple[bool, bool] = (False, False),
    contact_time: float = 0.0,
    cell: float | None = None,
    reach: float = 0.0,
) -> Arena:
    """The box 0 < x < 1, 0 < y < length_y of the centres of grains, in cells of the width `cell` or a little more.

    Without `cell`, that is a diameter and a little, or more where the gas is so dilute that most cells would be
    empty. The last column holds all of what a moving wall can `reach`, 1-reach < x: only there grains look for it.
    ValueError where a periodic box has no three cells across.
    """
    sparse = math.sqrt(length_y / (CELLS_PER_GRAIN * number))
    width = max(max(CELL * diameter, sparse) if cell is None else cell, 1.001 * reach)
    columns, rows = max(math.floor(1.0 / width), 1), max(math.floor(length_y / width), 1)
    for along, cells in zip(periodic, (columns, rows), strict=True):
        if along and cells < 3:
            raise ValueError(
                f"a periodic box must be three cells wide, and grains of diameter {diameter:g} leave {cells}"
            )
    return Arena(
        float(diameter), restitution, contact_time, length_y, *periodic, columns, rows, 1.0 / columns, length_y / rows
    )


class Dynamics:
    """Grains of one box: positions, velocities, clock, books and random numbers; `advance` runs their events.

    Units: L_x, T_*^(1/2), mass of a grain 1. time: of the state. Positions are those of centres.
    """

    def __init__(self, arena: Arena, wall: Any, positions: np.ndarray, velocities: np.ndarray, seed: int = 0):
        """positions, velocities: shape (N, 2), at time 0. Grains must not overlap; `smallest_gap` tells."""
        motion = np.hstack([positions, velocities, np.zeros((len(positions), 1))])
        column = np.clip((positions[:, 0] / arena.width).astype(np.int32), 0, arena.columns - 1)
        row = np.clip((positions[:, 1] / arena.height).astype(np.int32), 0, arena.rows - 1)
        self.arena, self.wall, self.time = arena, wall, 0.0
        memory: dict[str, np.ndarray] = {
            "motion": motion,
            "cells": np.stack([column, row], axis=1),
            "random": seeded(seed),
        }
        books = {"clock": np.zeros(CLOCK), "sums": np.zeros(SUMS), "counts": np.zeros(COUNTS, np.int64)}
        self._begin({**memory, **books, "epoch": np.zeros(1)})

    def _begin(self, memory: dict[str, np.ndarray], pace: float = FINEST) -> None:
        """Arrange the grains by cell, so that neighbours are neighbours in memory, and foresee all.

        pace: of the calendar of events, which corrects it; too fast does no harm.
        """
        cells = memory["cells"].astype(np.int32)
        number = len(cells)
        self._order = np.argsort(cells[:, 0] * self.arena.rows + cells[:, 1], kind="stable")
        motion, prospects = aligned(number, MOTION), aligned(number, PROSPECT)
        for name, column in zip(COLUMNS, memory["motion"].T, strict=True):
            motion[name] = column[self._order]
        self.grains = Grains(
            motion, prospects, np.zeros(self.arena.columns * self.arena.rows, np.int32),
            np.zeros((number + 2, 3), np.int32), calendar(prospects, pace),
            *(memory[name].copy() for name in ("clock", "random", "sums", "counts")),
        )  # fmt: skip
        self._epoch = int(memory["epoch"][0])
        events.fill_cells(self.grains, self.arena, cells[self._order])
        events.foresee_all(self.grains, self.arena, self.wall)

    def _own(self, *names: str) -> np.ndarray:
        """Columns of what is known of each grain, in the order in which they were given."""
        columns = [self.grains.motion[name] for name in names]
        own = np.empty((self.number, len(names)), columns[0].dtype)
        own[self._order] = np.stack(columns, axis=1)
        return own

    def memory(self) -> dict[str, np.ndarray]:
        """All that is needed to go on with the same bits, but for the count of stale events: all are foreseen anew."""
        grains = self.grains
        return {
            "motion": self._own(*COLUMNS), "cells": self._own("column", "row"),
            "epoch": np.array([self._epoch]), "clock": grains.clock.copy(), "random": grains.random.copy(),
            "sums": grains.sums.copy(), "counts": grains.counts.copy(), "time": np.array([self.time]),
        }  # fmt: skip

    def remember(self, memory: dict[str, np.ndarray]) -> None:
        """Take back what `memory` gave."""
        self.time = float(memory["time"][0])
        self._begin(memory)

    def advance(self, until: float) -> None:
        """Run all events up to a time; RunFailed when grains collide without end."""
        while until - self._epoch * EPOCH >= EPOCH:
            self._run(EPOCH)
            events.count_time_from(self.grains, EPOCH, self.wall.period)
            self._epoch += 1
            self._begin(self.memory(), self.grains.queue.pace[0])
        self._run(until - self._epoch * EPOCH)
        self.time = until

    def _run(self, until: float) -> None:
        while True:
            before = self.grains.clock[events.NOW]
            if events.run(self.grains, self.arena, self.wall, until, BUDGET) < BUDGET:
                return
            if self.grains.clock[events.NOW] - before < PROGRESS:
                now = self._epoch * EPOCH + before
                raise RunFailed(f"grains collide without end at t = {now:.6g}: inelastic collapse; set a contact time")

    @property
    def number(self) -> int:
        """How many grains there are."""
        return len(self.grains.motion)

    @property
    def velocities(self) -> np.ndarray:
        """Shape (N, 2)."""
        return self._own("vx", "vy")

    @property
    def positions(self) -> np.ndarray:
        """At the present time, shape (N, 2). Along a periodic direction they may lie just outside the box."""
        flight = self.time - self._epoch * EPOCH - self._own("time")
        return self._own("x", "y") + self.velocities * flight

    @property
    def energy(self) -> float:
        """Of all grains."""
        return 0.5 * float((self.velocities**2).sum())

    @property
    def smallest_gap(self) -> float:
        """The smallest distance between surfaces of grains, in diameters: negative where they overlap."""
        return events.smallest_gap(self.grains, self.arena, self.time - self._epoch * EPOCH)

    def closest_until(self, time: float, every: int) -> float:
        """Advance, and return the smallest gap seen right after every so many events: who just collided touches."""
        smallest = math.inf
        while self.time < time:
            end = min(time - self._epoch * EPOCH, EPOCH)
            while events.run(self.grains, self.arena, self.wall, end, every) == every:
                smallest = min(smallest, events.smallest_gap(self.grains, self.arena, self.grains.clock[events.NOW]))
            self.advance(self._epoch * EPOCH + end)
        return smallest

    def count(self, which: int) -> int:
        """How often something happened so far: `events.COLLISIONS` and the names beside it."""
        return int(self.grains.counts[which])

    def sum(self, which: int) -> float:
        """What has been summed so far: `events.LOSS` and the names beside it."""
        return float(self.grains.sums[which])
