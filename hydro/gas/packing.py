"""Density as an unknown without bounds: w = log(1/n - 1/n_p), from -inf where the gas packs to inf in a vacuum.

With eps = e^w, n = 1/(1/n_p + eps) and the gap 1 - n/n_p is eps n. In a closure that never packs, n_p = inf, w is
-log n and the gap 1. Near packing the gap may be far below the last digit of n; w does not lose it. All take and return
numbers or arrays of one shape.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.special import expit, logit  # these keep all digits of both 1-x and x, and overflow nowhere

from hydro.gas.closure import Closure


def log_void(gas: Closure, n):
    """w of a density 0 < n < n_p."""
    packed = gas.packing_density()
    return -np.log(n) if packed == math.inf else -logit(n / packed) - math.log(packed)


def density_at(gas: Closure, w):
    """n."""
    packed = gas.packing_density()
    return np.exp(-w) if packed == math.inf else packed * expit(-w - math.log(packed))


def gap_at(gas: Closure, w):
    """1 - n/n_p to all digits; also -d log n/dw."""
    packed = gas.packing_density()
    return np.ones_like(w) if packed == math.inf else expit(w + math.log(packed))
