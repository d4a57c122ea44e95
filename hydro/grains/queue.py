"""The queue of events: one per grain, the earliest on top, in a heap that knows where each grain stands."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydro.jit import part

BITS = 2  # children of a node: 2^BITS; with four their times lie in one line of the cache


class Queue(NamedTuple):
    """A heap: children of place k are at 4k+1 to 4k+4, and none is earlier than its parent. All of shape (N,)."""

    times: np.ndarray  # by place
    grains: np.ndarray  # by place
    places: np.ndarray  # by grain

    @classmethod
    def of(cls, times: np.ndarray) -> Queue:
        """With a time for each grain."""
        order = np.argsort(times, kind="stable").astype(np.int32)
        places = np.empty_like(order)
        places[order] = np.arange(order.size, dtype=np.int32)
        return cls(times[order], order, places)


@part(exact=True)
def reschedule(queue, grain, time):
    """Give a grain a new time."""
    times, count = queue.times, queue.times.size
    place = int(queue.places[grain])
    while place > 0:
        parent = (place - 1) >> BITS
        if times[parent] <= time:
            break
        _put(queue, place, queue.grains[parent], times[parent])
        place = parent
    while True:
        first = (place << BITS) + 1
        if first >= count:
            break
        child = first
        for other in range(first + 1, min(first + (1 << BITS), count)):
            child = other if times[other] < times[child] else child
        if times[child] >= time:
            break
        _put(queue, place, queue.grains[child], times[child])
        place = child
    _put(queue, place, grain, time)


@part(exact=True)
def _put(queue, place, grain, time):
    queue.times[place] = time
    queue.grains[place] = grain
    queue.places[grain] = place
