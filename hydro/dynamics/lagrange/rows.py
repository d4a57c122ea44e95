"""Arithmetic of rows."""

from __future__ import annotations

import numpy as np

from hydro.jit import part


@part(exact=True)
def add_difference(now, last, weight, out):
    """out = now + weight (now - last)."""
    for j in range(np.uint64(now.size)):
        out[j] = now[j] + weight * (now[j] - last[j])


@part(exact=True)
def add_row(target, values, factor):
    """target += factor values."""
    for j in range(np.uint64(target.size)):
        target[j] += factor * values[j]


@part(exact=True)
def copy_row(values, out):
    """out = values."""
    for j in range(np.uint64(out.size)):
        out[j] = values[j]
