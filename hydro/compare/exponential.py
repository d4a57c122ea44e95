"""The exponential stretch of a curve: where its logarithm is straight, and at which rate it grows or decays there."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

FEWEST = 7  # points of a stretch: two intervals in each third
LEAST_CHANGE = 1.0  # of the logarithm over a stretch: a factor e
DEVIATION = 0.01  # root mean square, of the logarithm from a straight line


class Stretch(NamedTuple):
    """value = at_start exp(rate (time - start)), by least squares of its logarithm, from start to end.

    error: half the range of the rates of its first, second and last third.
    """

    rate: float
    error: float
    start: float
    end: float
    points: int
    at_start: float


class NoStretch(ValueError):
    """A curve is nowhere exponential; says why."""


def exponential_stretch(times: np.ndarray, values: np.ndarray) -> Stretch:
    """The longest straight stretch of log(values) against times, both (points,), times increasing.

    NoStretch where none has FEWEST points, LEAST_CHANGE and no more than DEVIATION. Values must be positive to count.
    """
    there = values > 0.0
    t, y = times[there], np.log(values[there])
    if t.size < FEWEST:
        raise NoStretch(f"{t.size} checkpoints are too few: a rate needs {FEWEST}")
    longest = max((end for first in range(t.size - FEWEST + 1) for end in longest_from(t, y, first)), default=None)
    if longest is None:
        raise NoStretch(
            f"no exponential stretch: nowhere does it stay within {DEVIATION:.0%} of an exponential over {FEWEST} "
            "checkpoints and a factor e or more"
        )
    _, first, last = longest
    part = slice(first, last + 1)
    level, rate = np.polynomial.polynomial.polyfit(t[part] - t[first], y[part], 1)
    ends = first + np.arange(4) * (last - first) // 3
    error = 0.5 * np.ptp(np.diff(y[ends]) / np.diff(t[ends]))
    return Stretch(float(rate), float(error), float(t[first]), float(t[last]), last - first + 1, float(np.exp(level)))


def longest_from(t: np.ndarray, y: np.ndarray, first: int) -> list[tuple[float, int, int]]:
    """(duration, first, last) of the longest straight stretch that begins at a point; none if there is none."""
    s, z = t[first:] - t[first], y[first:] - y[first]
    count = np.arange(1, s.size + 1)

    def covariance(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return (np.cumsum(a * b) - np.cumsum(a) * np.cumsum(b) / count) / count

    spread, scatter, joint = (part[FEWEST - 1 :] for part in (covariance(s, s), covariance(z, z), covariance(s, z)))
    change = np.abs(joint / spread) * s[FEWEST - 1 :]
    deviation = np.sqrt(np.maximum(scatter - joint**2 / spread, 0.0))
    good = np.flatnonzero((change >= LEAST_CHANGE) & (deviation <= DEVIATION)) + FEWEST - 1
    return [(float(s[end]), first, first + int(end)) for end in good[-1:]]
