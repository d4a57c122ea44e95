"""What is known of grains and of their box, in arrays: the records of a grain, and the cells that they are in.

Each grain has a time of its own: its position is that of its last collision, and it flies freely from there.

Units: length L_x, velocity T_*^(1/2), mass of a grain 1.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydro.grains.queue import Queue, Ring
from hydro.jit import inline

# What is known of a grain: a line of the cache. And of its next events: half a line.
MOTION = np.dtype({
    "names": ["x", "y", "vx", "vy", "time", "count", "following", "column", "row"],
    "formats": ["f8"] * 5 + ["i4"] * 4, "itemsize": 64,
})  # fmt: skip
PROSPECT = np.dtype({
    "names": ["event", "collision", "partner", "seen", "later", "step_x", "step_y"],
    "formats": ["f8"] * 2 + ["i4"] * 3 + ["i2"] * 2,
})  # fmt: skip
CELL = np.dtype([("first", "i4"), ("second", "i4")])  # the grains in a cell; from the second on, one tells the next
CANDIDATE, ACROSS_X, ACROSS_Y = range(3)  # columns of `candidates`
NOW, ORIGIN, CLOCK = range(3)


class Grains(NamedTuple):
    """All that changes with an event.

    motion (N,): of each grain the position, velocity, and the time they belong to; how many collisions it has had; the
    next grain of the same cell; column and row of that. prospects (N,): the time of its next event, and of its next
    collision; its partner in that, and how many collisions the partner had had when it was foreseen; the next grain in
    the queue; by how many columns and rows the next event takes it to another cell, if it does. cells: first and second
    grain of each, NOBODY where there is none. candidates (N + 2, 3): room for the grains in a block of cells, and how
    often one goes round the box to them. soon, sooner: grains whose events are looked at ahead. clock (2,): time of the
    last event, and what to add to times to count them from the beginning of a period of the wall. random (4,): the
    state of the random numbers. sums (5,): energy given by the wall, energy lost, the virial, momentum given to the
    walls at x = 0 and x = 1. counts (5,): collisions, impacts on the driving wall, collisions that the contact time
    made elastic, stale events, changes of cell.
    """

    motion: np.ndarray
    prospects: np.ndarray
    cells: np.ndarray
    candidates: np.ndarray
    queue: Queue
    soon: Ring
    sooner: Ring
    clock: np.ndarray
    random: np.ndarray
    sums: np.ndarray
    counts: np.ndarray


class Arena(NamedTuple):
    """What no event changes: grains, box, and the borders of cells, which are a diameter or more apart."""

    diameter: float
    restitution: float
    contact_time: float
    length_y: float
    periodic_x: bool
    periodic_y: bool
    columns: int
    rows: int
    borders_x: np.ndarray  # (columns + 1,)
    borders_y: np.ndarray  # (rows + 1,)


@inline(exact=True)
def position_at(motion, i, time):
    """Where grain i is at a time, if nothing happens to it."""
    flight = time - motion[i].time
    return motion[i].x + motion[i].vx * flight, motion[i].y + motion[i].vy * flight


@inline(exact=True)
def move_to(motion, i, time):
    """Bring grain i to a time."""
    motion[i].x, motion[i].y = position_at(motion, i, time)
    motion[i].time = time


@inline(exact=True)
def nearest_image(distance, length, periodic):
    """The shortest of the distances between periodic images."""
    return distance - length * np.rint(distance / length) if periodic else distance
