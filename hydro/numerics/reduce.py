"""Reductions over rows."""

from __future__ import annotations

import numpy as np

from hydro.jit import inline, part

MAGNITUDE = np.int64(0x7FFFFFFFFFFFFFFF)  # all bits of a double but its sign


@part
def store_largest(values, largest, i):
    """largest[i] = the maximum of |values|; a NaN, of either sign, counts as larger than all numbers.

    The bits of numbers without their sign, read as integers, are in the same order, and a maximum of integers is
    vectorized while one of numbers that may be NaN is not.
    """
    bits = values.view(np.int64)
    most = np.int64(0)
    for k in range(np.uint64(bits.size)):
        most = max(most, bits[k] & MAGNITUDE)
    largest.view(np.int64)[i] = most


@inline
def total(values):
    """Sum of an array."""
    result = 0.0
    for value in values:
        result += value
    return result


@inline
def largest(values):
    """Maximum of an array that is nowhere negative; NaN if one is in it."""
    result = 0.0
    for value in values:
        result = result if value <= result else value
    return result
