"""Measuring on a noisy machine: interleaved rounds, medians, triad bandwidth; and tables of the results."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable
from pathlib import Path

import numba
import numpy as np
from numba import prange

TRIAD_LENGTH = 1 << 24  # 128 MiB an array: far beyond any cache
TRIAD_BYTES = 24  # counted as STREAM does, without write-allocate


def interleaved(rounds: int, *measures: Callable[[], float]) -> np.ndarray:
    """Every measure once a round, one after the other, so that all see the same noise; shape (rounds, measures)."""
    return np.array([[measure() for measure in measures] for _ in range(rounds)])


def ratio(rates: np.ndarray, over: np.ndarray) -> str:
    """Median of the ratios round by round, and their range."""
    ratios = rates / over
    return f"{np.median(ratios):.3g} ({ratios.min():.3g} to {ratios.max():.3g})"


def mega(rates: np.ndarray) -> str:
    """Median of rates, in millions."""
    return f"{np.median(rates) / 1e6:.3g}"


def processor() -> str:
    """The processor's name, as the system gives it."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or "unknown"


@numba.njit(parallel=True)
def triad(a, b, c):
    """a = b + 3 c."""
    for i in prange(a.size):
        a[i] = b[i] + 3.0 * c[i]


SHORT = 1024  # numbers that stay in the nearest cache
REPEATS = 20000


@numba.njit(fastmath=True, error_model="numpy")
def multiply_and_add(a, b, repeats):
    """Eight sums and eight products a number."""
    for _ in range(repeats):
        for i in range(a.size):
            x = a[i]
            for _ in range(8):
                x = x * b + b
            a[i] = x


@numba.njit(error_model="numpy")
def divide(a, b, repeats):
    """One division a number."""
    for _ in range(repeats):
        for i in range(a.size):
            a[i] = b / a[i]


@numba.njit(error_model="numpy")
def root(a, b, repeats):
    """One root a number, and a sum."""
    for _ in range(repeats):
        for i in range(a.size):
            a[i] = np.sqrt(a[i] + b)


def nanoseconds() -> dict[str, float]:
    """What one sum or product, one division and one root take at best, on one core."""
    taken = {}
    for name, function, count in (("sums", multiply_and_add, 16), ("divisions", divide, 1), ("roots", root, 1)):
        function(np.ones(SHORT), 0.5, 1)
        started = time.perf_counter()
        function(np.ones(SHORT), 0.5, REPEATS)
        taken[name] = 1e9 * (time.perf_counter() - started) / (SHORT * REPEATS * count)
    return {**taken, "products": taken["sums"]}


class Triad:
    """Main memory bandwidth of so many threads."""

    def __init__(self, threads: int):
        self._threads = threads
        self._arrays = [np.ones(TRIAD_LENGTH) for _ in range(3)]
        self.bandwidth()

    def bandwidth(self) -> float:
        """Bytes per second of one triad."""
        numba.set_num_threads(self._threads)
        start = time.perf_counter()
        triad(*self._arrays)
        return TRIAD_BYTES * TRIAD_LENGTH / (time.perf_counter() - start)
