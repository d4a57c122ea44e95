"""Measuring on a noisy machine: interleaved rounds, medians, triad bandwidth; and tables of the results."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Sequence
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


def table(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A Markdown table."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)


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
