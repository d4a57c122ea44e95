"""The queue of events: one per grain, in a calendar whose days hold few of them.

Brown, Commun. ACM 31, 1220 (1988); Paul, J. Comput. Phys. 221, 615 (2007).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hydro.jit import inline

NOBODY = -1
DAYS_PER_GRAIN = 4  # in a year, at least
EVENTS_PER_DAY = 0.5
FINEST = 2.0**60
EVENTS, DAY = range(2)
NEVER = 2.0**62  # a day that does not come


class Queue(NamedTuple):
    """A calendar. What has a place in it, an array of records, has two fields: `event`, its time, and `later`.

    days (a power of two,): first grain of each day of a year; `later` is the next of the same day. What comes only in
    years to come is passed over until then. today (1,): the present day, counted through all years. pace: days in a
    unit of time.
    """

    entries: np.ndarray
    days: np.ndarray
    today: np.ndarray
    pace: np.ndarray
    since: np.ndarray


@inline(exact=True)
def day_of(queue, time):
    """The day on which a time lies."""
    return np.int64(min(time * queue.pace[0], NEVER))


@inline(exact=True)
def page_of(queue, day):
    """Where the calendar keeps a day. What should have been is kept today."""
    return max(day, queue.today[0]) & (queue.days.size - 1)


@inline(exact=True)
def earliest_today(queue):
    """The grain with the earliest event of today; NOBODY if there is none."""
    entries, today = queue.entries, queue.today[0]
    earliest, time = np.int64(NOBODY), math.inf
    i = np.int64(queue.days[page_of(queue, today)])
    while i >= 0:
        at = entries[i].event
        if at < time and day_of(queue, at) <= today:
            earliest, time = i, at
        i = np.int64(entries[i].later)
    return earliest


@inline(exact=True)
def schedule(queue, i, time):
    """Enter the event of a grain that has none."""
    entries = queue.entries
    page = page_of(queue, day_of(queue, time))
    entries[i].event = time
    entries[i].later = queue.days[page]
    queue.days[page] = i


@inline(exact=True)
def cancel(queue, i):
    """Take the event of a grain out."""
    entries = queue.entries
    page = page_of(queue, day_of(queue, entries[i].event))
    before = np.int64(queue.days[page])
    if before == i:
        queue.days[page] = entries[i].later
        return
    while entries[before].later != i:
        before = np.int64(entries[before].later)
    entries[before].later = entries[i].later


@inline(exact=True)
def begin(queue, now):
    """Enter all events."""
    queue.days[:] = NOBODY
    queue.today[0] = day_of(queue, now)
    queue.since[EVENTS], queue.since[DAY] = 0, queue.today[0]
    for i in range(queue.entries.size):
        schedule(queue, i, queue.entries[i].event)


@inline(exact=True)
def reckon(queue, now):
    """After as many events as there are grains, or a year, give days another length if they held too many or too few."""
    today, since, pace = queue.today, queue.since, queue.pace
    if since[EVENTS] < queue.entries.size and today[0] < since[DAY] + queue.days.size:
        return
    change = (since[EVENTS] + 1) / (today[0] - since[DAY] + 1) / EVENTS_PER_DAY
    if not 0.5 < change < 2.0:
        pace[0] = min(pace[0] * change, FINEST)
        begin(queue, now)
    since[EVENTS], since[DAY] = 0, today[0]


def calendar(entries: np.ndarray, pace: float) -> Queue:
    """Without events."""
    days = 1 << (DAYS_PER_GRAIN * len(entries) - 1).bit_length()
    return Queue(entries, np.full(days, NOBODY, np.int32), np.zeros(1, np.int64), np.array([pace]), np.zeros(2, np.int64))


def aligned(number: int, kind: np.dtype) -> np.ndarray:
    """Zeros that begin with a line of the cache."""
    line = 64
    room = np.zeros(number * kind.itemsize + line, np.uint8)
    start = -room.ctypes.data % line
    return room[start : start + number * kind.itemsize].view(kind)
