"""The queue of events: one per grain, in a calendar whose days hold one or two of them.

Nothing in it depends on the number of grains. Brown, Commun. ACM 31, 1220 (1988); Paul, J. Comput. Phys. 221, 615
(2007).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hydro.jit import fetch, inline

NOBODY = -1
WAITING = -2  # in place of the next grain on a page: not on one yet
ROOM = 8  # for grains that wait, a power of two
SOON = 64  # days, more than ROOM: grains whose events come sooner are entered at once
EVENTS_IN_DAY = 1.4  # aimed at
LOOKS = 4  # at the pace, in N events or a year
DAYS_PER_GRAIN = 2  # in a year, at least
FINEST = 2.0**60  # days in a unit of time, at most
NEVER = 2.0**62  # a day that does not come
LINE = 64  # bytes in a line of the cache
EVENTS, DAY = range(2)


class Ring(NamedTuple):
    """Places for grains or nobody, (a power of two,), which take turns; turn (1,): how many have been taken."""

    places: np.ndarray
    turn: np.ndarray


class Queue(NamedTuple):
    """A calendar, with a page for each day of a year. Next year the pages are used again.

    entries (N,): records of grains; among their fields are `event`, its time, and `later`, the next grain on the same
    page. pages (a power of two,): first grain of each. today (1,): counted from time zero, through all years. pace
    (1,): days in a unit of time. since (2,): events since the pace was last looked at, and the day of that. waiting:
    grains that are not on a page yet.
    """

    entries: np.ndarray
    pages: np.ndarray
    today: np.ndarray
    pace: np.ndarray
    since: np.ndarray
    waiting: Ring


def calendar(entries: np.ndarray, pace: float) -> Queue:
    """For the events of all entries, as yet without any."""
    pages = np.full(1 << (DAYS_PER_GRAIN * len(entries) - 1).bit_length(), NOBODY, np.int32)
    return Queue(entries, pages, np.zeros(1, np.int64), np.array([pace]), np.zeros(2, np.int64), ring(ROOM))


def ring(places: int) -> Ring:
    """With nobody in it."""
    return Ring(np.full(places, NOBODY, np.int32), np.zeros(1, np.int64))


def aligned(number: int, record: np.dtype) -> np.ndarray:
    """So many records of zeros that begin with a line of the cache."""
    size = number * record.itemsize
    room = np.zeros(size + LINE, np.uint8)
    start = -room.ctypes.data % LINE
    return room[start : start + size].view(record)


@inline(exact=True)
def put(ring, i):
    """Put a grain, or nobody, into a ring; returns the one in whose place it comes, which was there longest."""
    place = ring.turn[0] & (ring.places.size - 1)
    longest = np.int64(ring.places[place])
    ring.places[place] = i
    ring.turn[0] += 1
    return longest


@inline(exact=True)
def put_out(ring, i):
    """Leave nobody in the place of a grain."""
    for place in range(ring.places.size):
        if ring.places[place] == i:
            ring.places[place] = NOBODY


@inline(exact=True)
def day_of(queue, time):
    """The day on which a time lies."""
    return np.int64(min(time * queue.pace[0], NEVER))


@inline(exact=True)
def page_of(queue, day):
    """The page of a day; of today, for what should have been."""
    return max(day, queue.today[0]) & (queue.pages.size - 1)


@inline(exact=True)
def first_on(queue, day):
    """The first grain on the page of a day, NOBODY if that is empty."""
    return np.int64(queue.pages[page_of(queue, day)])


@inline(exact=True)
def earliest_today(queue):
    """The grain with the earliest event of today, NOBODY if there is none. What comes in other years is passed over."""
    entries, today = queue.entries, queue.today[0]
    earliest, time = np.int64(NOBODY), math.inf
    i = first_on(queue, today)
    while i >= 0:
        at = entries[i].event
        if at < time and day_of(queue, at) <= today:
            earliest, time = i, at
        i = np.int64(entries[i].later)
    return earliest


@inline(exact=True)
def tomorrow(queue):
    """Go on to the next day."""
    queue.today[0] += 1
    wait(queue, NOBODY)


@inline(exact=True)
def schedule(queue, i, time):
    """Take in the event of a grain that has none; its page, unless it is one of the next, has to be brought near."""
    day = day_of(queue, time)
    queue.entries[i].event = time
    if day < queue.today[0] + SOON:
        enter(queue, i)
    else:
        fetch(queue.pages, page_of(queue, day))
        queue.entries[i].later = WAITING
        wait(queue, i)


@inline(exact=True)
def wait(queue, i):
    """Have a grain, or nobody, wait until the page of its event is near; who has waited longest is entered."""
    longest = put(queue.waiting, i)
    if longest >= 0:
        enter(queue, longest)


@inline(exact=True)
def enter(queue, i):
    """Put a grain on the page of its event."""
    page = page_of(queue, day_of(queue, queue.entries[i].event))
    queue.entries[i].later = queue.pages[page]
    queue.pages[page] = i


@inline(exact=True)
def cancel(queue, i):
    """Take the event of a grain out."""
    if queue.entries[i].later == WAITING:
        put_out(queue.waiting, i)
    else:
        take_out(queue, i)


@inline(exact=True)
def take_out(queue, i):
    """Take a grain off the page of its event."""
    entries, page = queue.entries, page_of(queue, day_of(queue, queue.entries[i].event))
    before = np.int64(queue.pages[page])
    if before == i:
        queue.pages[page] = entries[i].later
        return
    while entries[before].later != i:
        before = np.int64(entries[before].later)
    entries[before].later = entries[i].later


@inline(exact=True)
def schedule_all(queue, now):
    """Enter the events of all grains, none of which is before now."""
    queue.pages[:], queue.waiting.places[:] = NOBODY, NOBODY
    queue.today[0] = day_of(queue, now)
    queue.since[EVENTS], queue.since[DAY] = 0, queue.today[0]
    for i in range(queue.entries.size):
        enter(queue, i)


@inline(exact=True)
def keep_pace(queue, now):
    """Change the length of days that have held too many events or too few, since it was last looked at."""
    since, today = queue.since, queue.today[0]
    if LOOKS * since[EVENTS] < queue.entries.size and LOOKS * (today - since[DAY]) < queue.pages.size:
        return
    events_in_day = (since[EVENTS] + 1) / (today - since[DAY] + 1)
    since[EVENTS], since[DAY] = 0, today
    if not 0.7 < events_in_day / EVENTS_IN_DAY < 1.4:
        queue.pace[0] = min(queue.pace[0] * events_in_day / EVENTS_IN_DAY, FINEST)
        schedule_all(queue, now)
