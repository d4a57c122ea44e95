"""The queue of events: one per grain, the earliest on top, in a heap that knows where each grain stands."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydro.jit import inline

ROOT = 3  # place of the earliest: the children of any then begin at a multiple of four and share lines of the cache
LINE = 64  # bytes in a line of the cache


class Queue(NamedTuple):
    """A heap: children of place k are at 4k-8 to 4k-5, and none is earlier than its parent.

    times, grains (N + 7,): by place, infinite behind the last grain. places (N,): by grain.
    """

    times: np.ndarray
    grains: np.ndarray
    places: np.ndarray

    @classmethod
    def of(cls, times: np.ndarray) -> Queue:
        """With a time for each grain."""
        order = np.argsort(times, kind="stable")
        places = slice(ROOT, ROOT + order.size)
        queue = cls(aligned(order.size + 7), aligned(order.size + 7, np.int32), np.empty(order.size, np.int32))
        queue.times[:] = np.inf
        queue.times[places], queue.grains[places] = times[order], order
        queue.places[order] = np.arange(places.start, places.stop)
        return queue


def aligned(shape: int | tuple[int, ...], kind: type = np.float64) -> np.ndarray:
    """Zeros that begin with a line of the cache."""
    size = int(np.prod(shape)) * np.dtype(kind).itemsize
    room = np.empty(size + LINE, np.uint8)
    start = -room.ctypes.data % LINE
    room.fill(0)
    return room[start : start + size].view(kind).reshape(shape)


@inline(exact=True)
def children(place):
    """The first of the four places below one."""
    return 4 * place - 8


@inline(exact=True)
def reschedule(queue, grain, time):
    """Give a grain a new time."""
    times, end = queue.times, queue.places.size + ROOT
    place = np.int64(queue.places[grain])
    while place > ROOT:
        parent = (place >> 2) + 2
        if times[parent] <= time:
            break
        _put(queue, place, queue.grains[parent], times[parent])
        place = parent
    while True:
        first = children(place)
        if first >= end:
            break
        left = first + (times[first + 1] < times[first])
        right = first + 2 + (times[first + 3] < times[first + 2])
        child = right if times[right] < times[left] else left
        if times[child] >= time:
            break
        _put(queue, place, queue.grains[child], times[child])
        place = child
    _put(queue, place, grain, time)


@inline(exact=True)
def _put(queue, place, grain, time):
    queue.times[place] = time
    queue.grains[place] = grain
    queue.places[grain] = place
