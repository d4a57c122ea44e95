"""Grains in a box, advanced in time."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import numpy as np

from hydro.errors import RunFailed
from hydro.grains import cell_list, cells, events, prediction
from hydro.grains.books import COUNTS, SUMS
from hydro.grains.prefetch import LAG
from hydro.grains.queue import FINEST, aligned, calendar, ring
from hydro.grains.random import seeded
from hydro.grains.state import CLOCK, MOTION, NOW, PROSPECT, Arena, Grains

EPOCH = 0.25  # times are counted from the last multiple of this: small numbers have fine digits
BUDGET = 1_000_000  # events between looks at the clock
PROGRESS = 1e-13  # of the clock in as many events, if grains do not collide without end
COLUMNS = ("x", "y", "vx", "vy", "time")  # of what is kept as `motion`


def kept_places(memory: dict[str, np.ndarray]) -> np.ndarray:
    """Positions at the time of `Dynamics.memory`, shape (N, 2); in a periodic direction maybe out of the box."""
    motion = memory["motion"]
    flight = memory["time"][0] - memory["epoch"][0] * EPOCH - motion[:, 4:]
    return motion[:, :2] + motion[:, 2:4] * flight


class Dynamics:
    """Grains of one box: positions, velocities, clock, books and random numbers; `advance` runs their events.

    Units: L_x, T_*^(1/2), mass of a grain 1. time: of the state. Positions are those of centres.
    """

    def __init__(
        self,
        arena: Arena,
        wall: Any,
        positions: np.ndarray,
        velocities: np.ndarray,
        seed: int = 0,
        cell: float | None = None,
    ):
        """positions, velocities: shape (N, 2), at time 0. Grains must not overlap; `smallest_gap` tells.

        cell: the least width of cells, which are then equal; without it they go by how crowded the grains are.
        """
        self.arena, self.wall, self.time, self._cell = arena, wall, 0.0, cell
        books = {"clock": np.zeros(CLOCK), "sums": np.zeros(SUMS), "counts": np.zeros(COUNTS, np.int64)}
        motion = np.hstack([positions, velocities, np.zeros((len(positions), 1))])
        self._begin({"motion": motion, "random": seeded(seed), "epoch": np.zeros(1), **books})

    def _begin(self, memory: dict[str, np.ndarray], pace: float = FINEST) -> None:
        """Choose cells, arrange the grains by cell, so that neighbours are neighbours in memory, and foresee all.

        pace: of the calendar of events, which corrects it; too fast does no harm.
        """
        x_y, velocities, times = memory["motion"][:, :2], memory["motion"][:, 2:4], memory["motion"][:, 4:]
        places = x_y + velocities * np.maximum(memory["clock"][NOW] - times, 0.0)
        if self._cell is None:
            self.arena = cells.crowded(self.arena, places, getattr(self.wall, "amplitude", 0.0))
        else:
            self.arena = cells.equal(self.arena, self._cell)
        inside, number = cells.inside(self.arena, places), len(places)
        self._order = np.argsort(inside[:, 0] * self.arena.rows + inside[:, 1], kind="stable")
        motion, prospects = aligned(number, MOTION), aligned(number, PROSPECT)
        for name, column in zip(COLUMNS, memory["motion"].T, strict=True):
            motion[name] = column[self._order]
        self.grains = Grains(
            motion, prospects, cell_list.no_cells(self.arena),
            np.zeros((number + 2, 3), np.int32), calendar(prospects, pace), ring(LAG), ring(LAG),
            *(memory[name].copy() for name in ("clock", "random", "sums", "counts")),
        )  # fmt: skip
        self._epoch = int(memory["epoch"][0])
        cell_list.fill_cells(self.grains, self.arena, inside[self._order])
        prediction.predict_all(self.grains, self.arena, self.wall)

    def _own(self, *names: str) -> np.ndarray:
        """Columns of what is known of each grain, in the order in which they were given."""
        columns = [self.grains.motion[name] for name in names]
        own = np.empty((self.number, len(names)), columns[0].dtype)
        own[self._order] = np.stack(columns, axis=1)
        return own

    remembered: ClassVar = {
        "motion": (
            "of grains: x, y, velocities along x and y, and the time they belong to, since the epoch",
            "L_x, T_*^(1/2), L_x/T_*^(1/2)",
        ),
        "epoch": ("number of the quarter of a time unit that times of grains are counted from", "1"),
        "clock": (
            "time of the last event since the epoch, and of that in the period of the wall",
            "L_x/T_*^(1/2)",
        ),
        "random": ("state of the random numbers", "1"),
        "sums": (
            "energy from the wall, lost in collisions, virial, momentum to the walls x = 0 and x = 1",
            "a grain's mass times T_* or T_*^(1/2)",
        ),
        "counts": ("collisions, impacts on the driving wall, soft collisions, stale events, changes of cell", "1"),
        "time": ("time of the grains", "L_x/T_*^(1/2)"),
    }

    def memory(self) -> dict[str, np.ndarray]:
        """All that is needed to go on with the same bits. Only stale events and changes of cell count differently: all
        is foreseen anew, in new cells.
        """
        grains = self.grains
        return {
            "motion": self._own(*COLUMNS), "epoch": np.array([self._epoch]), "clock": grains.clock.copy(),
            "random": grains.random.copy(), "sums": grains.sums.copy(), "counts": grains.counts.copy(),
            "time": np.array([self.time]),
        }  # fmt: skip

    def remember(self, memory: dict[str, np.ndarray]) -> None:
        """Take back what `memory` gave."""
        self.time = float(memory["time"][0])
        self._begin(memory)

    def advance(self, until: float) -> None:
        """Run all events up to a time; RunFailed when grains collide without end."""
        while until - self._epoch * EPOCH >= EPOCH:
            self._run(EPOCH)
            events.shift_times(self.grains, EPOCH, self.wall.period)
            self._epoch += 1
            memory, pace = self.memory(), self.grains.queue.pace[0]
            del self.grains  # before as much is taken again
            self._begin(memory, pace)
        self._run(until - self._epoch * EPOCH)
        self.time = until

    def _run(self, until: float) -> None:
        while True:
            before = self.grains.clock[NOW]
            if events.run(self.grains, self.arena, self.wall, until, BUDGET) < BUDGET:
                return
            if self.grains.clock[NOW] - before < PROGRESS:
                now = self._epoch * EPOCH + before
                problem = f"grains collide without end at t = {now:.6g}: inelastic collapse; set a contact time"
                raise RunFailed(problem, remedy="grains.contact_time=1e-6")

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
    def places(self) -> np.ndarray:
        """Positions within the box, shape (N, 2): 0 <= x < 1 and 0 <= y < length_y where it is periodic."""
        places = self.positions
        for axis, (periodic, length) in enumerate(
            ((self.arena.periodic_x, 1.0), (self.arena.periodic_y, self.arena.length_y))
        ):
            if periodic:
                places[:, axis] %= length
                places[places[:, axis] == length, axis] = 0.0  # what was negative by round-off
        return places

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
                smallest = min(smallest, events.smallest_gap(self.grains, self.arena, self.grains.clock[NOW]))
            self.advance(self._epoch * EPOCH + end)
        return smallest

    def count(self, which: int) -> int:
        """How often something happened so far: `books.COLLISIONS` and the names beside it."""
        return int(self.grains.counts[which])

    def sum(self, which: int) -> float:
        """What has been summed so far: `books.LOSS` and the names beside it."""
        return float(self.grains.sums[which])
