"""Random numbers inside kernels: xoshiro256++ of Blackman and Vigna, ACM Trans. Math. Softw. 47, 36 (2021).

The state is an array of four 64-bit words, so that it can be saved: a run goes on with the numbers it would have had.
"""

from __future__ import annotations

import math

import numpy as np

from hydro.jit import inline, part


def seeded(seed: int) -> np.ndarray:
    """A state for a seed, shape (4,)."""
    return np.random.SeedSequence(seed).generate_state(4, np.uint64)


@inline(exact=True)
def _rotated(word, places):
    return (word << np.uint64(places)) | (word >> np.uint64(64 - places))


@part(exact=True)
def uniform(state):
    """The next number, uniform in (0, 1)."""
    word = _rotated(state[0] + state[3], 23) + state[0]
    shifted = state[1] << np.uint64(17)
    state[2] ^= state[0]
    state[3] ^= state[1]
    state[1] ^= state[2]
    state[0] ^= state[3]
    state[2] ^= shifted
    state[3] = _rotated(state[3], 45)
    return (np.float64(word >> np.uint64(11)) + 0.5) * 2.0**-53


@part(exact=True)
def rayleigh(state):
    """Distributed as v exp(-v^2/2): the normal velocity of a Maxwellian flux of unit temperature."""
    return math.sqrt(-2.0 * math.log(uniform(state)))


@part(exact=True)
def normal(state):
    """Normally distributed, of unit variance."""
    return rayleigh(state) * math.cos(2.0 * math.pi * uniform(state))
