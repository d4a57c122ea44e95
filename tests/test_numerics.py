"""Pieces of kernels."""

from __future__ import annotations

import numpy as np

from hydro.jit import kernel
from hydro.numerics.reduce import store_largest


def test_a_nan_of_either_sign_is_the_largest():
    out = np.zeros(3)
    for i, odd in enumerate((np.nan, -np.nan, 2.0)):
        largest_of(np.array([1.0, odd, 0.5]), out, i)
    assert np.isnan(out[0]) and np.isnan(out[1]) and out[2] == 2.0


@kernel
def largest_of(values, out, i):
    store_largest(values, out, i)
