"""Observed orders of convergence, and the limits that sequences of numbers tend to."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

ORDERS = (0.05, 20.0)  # that are looked for


def orders(sizes: Sequence[float], errors: Sequence[float]) -> list[float]:
    """Observed order between each pair of neighbours; `sizes` are cell widths or time steps."""
    return list(np.diff(np.log(np.asarray(errors))) / np.diff(np.log(np.asarray(sizes))))


def fitted_order(sizes: Sequence[float], errors: Sequence[float]) -> float:
    """Slope of log error over log size by least squares: for errors that scatter from grid to grid."""
    return float(np.polyfit(np.log(np.asarray(sizes)), np.log(np.asarray(errors)), 1)[0])


def order_of_values(sizes: Sequence[float], values: Sequence[float]) -> float | None:
    """The order p with which values = limit + constant size^p at three sizes, coarse to fine.

    None where there is no such p: where the differences do not shrink, or change their sign.
    """
    from scipy.optimize import brentq  # slow to import

    (a, b, c), (first, second) = sizes, (low - high for low, high in pairwise(values))
    if first == 0.0 or second == 0.0:
        return None

    def excess(p: float) -> float:
        return (a**p - b**p) / (b**p - c**p) - first / second

    low, high = ORDERS
    return float(brentq(excess, low, high)) if excess(low) * excess(high) < 0.0 else None


class Limit(NamedTuple):
    """What values tend to, its error bar, and the order with which they do; None where that cannot be said."""

    value: float
    error: float
    order: float | None


def richardson(sizes: Sequence[float], values: Sequence[float], order: float) -> Limit:
    """The limit of values at two sizes or more, coarse to fine, for errors of a known order, from the two finest.

    The error bar is the distance from the limit that the two before give, which vanishes where the values follow the
    order. Where the order that is seen is more than a factor of two off, or there is none, it is at least the range of
    the last three values; with two sizes alone, the distance from the last value.
    """
    limits = [
        fine + (fine - coarse) / ((before / after) ** order - 1.0)
        for (before, after), (coarse, fine) in zip(pairwise(sizes), pairwise(values), strict=True)
    ]
    if len(limits) == 1:
        return Limit(limits[0], abs(limits[0] - values[-1]), None)
    seen, error = order_of_values(sizes[-3:], values[-3:]), abs(limits[-1] - limits[-2])
    if seen is None or not 0.5 * order <= seen <= 2.0 * order:
        error = max(error, max(values[-3:]) - min(values[-3:]))
    return Limit(limits[-1], error, seen)
