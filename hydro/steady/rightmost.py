"""Eigenvalues of largest real part, by iteration around shifts, so that none is missed.

Around a shift, iteration finds the nearest eigenvalues: all of those in a disc. Oscillations as fast as sound may lie
far from the real axis and yet decay more slowly than what lies near zero. So discs are laid along the imaginary axis
until they cover everything right of the last eigenvalue that is wanted, up to the frequency of sound across the box,
and on as long as faster sound does not decay faster. A disc that leaves a gap is widened.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

NEAREST = 10  # eigenvalues around a shift at first
EDGE = 1e-6  # share of its radius by which a disc is taken to be smaller: the furthest eigenvalue may have an equal
ROUGH = 0.05  # error of a hint, over its absolute value
FEW = 5  # eigenvalues around a hint at first
OVERLAP = 0.4  # how far the next shift stands off, over the height of what was covered last
SLOW = 0.15  # of the frequency of sound: oscillations below are not sound


class Disc(NamedTuple):
    """All eigenvalues within `radius` of `shift`, (count,), and their vectors, (size, count)."""

    shift: complex
    radius: float
    values: np.ndarray
    vectors: np.ndarray

    @classmethod
    def of(cls, shift: complex, values: np.ndarray, vectors: np.ndarray, whole: bool) -> Disc:
        """From the nearest eigenvalues, or from all of them."""
        off = np.abs(values - shift)
        radius = math.inf if whole else float(off.max()) * (1.0 - EDGE)
        return cls(shift, radius, values[off < radius], vectors[:, off < radius])

    def holds(self, value: complex) -> bool:
        """Whether a value lies within."""
        return abs(value - self.shift) < self.radius

    def height(self, left: float, right: float) -> float:
        """How far above and below the shift the disc covers the strip of real parts between `left` and `right`."""
        far = max(abs(left - self.shift.real), abs(right - self.shift.real))
        return math.sqrt(max(self.radius**2 - far**2, 0.0)) if self.radius < math.inf else math.inf


Around = Callable[[complex], Callable[[int], Disc]]


class Search:
    """What has been found; of a pair that oscillates, the one of positive frequency."""

    def __init__(self, count: int, start: float):
        self.count, self.start = count, start
        self.discs: list[Disc] = []
        self.values: list[complex] = []
        self.vectors: list[np.ndarray] = []

    def add(self, disc: Disc) -> None:
        """Note what no disc before has found."""
        for value, vector in zip(disc.values, disc.vectors.T, strict=True):
            if abs(value.imag) < EDGE * abs(value - disc.shift):
                value = complex(value.real)
            if value.imag >= 0.0 and not any(before.holds(value) for before in self.discs):
                self.values.append(complex(value))
                self.vectors.append(vector)
        self.discs.append(disc)

    def cover(self, nearest: Callable[[int], Disc], shift: complex, reached: float) -> float:
        """Add discs around a shift until they join what is covered up to `reached`; returns up to where it is then."""
        wanted = NEAREST if shift.imag else NEAREST + 2 * self.count
        while True:
            self.add(disc := nearest(wanted))
            height = disc.height(self.edge, self.start)
            if disc.radius == math.inf or (len(self.values) >= self.count and shift.imag - height <= reached):
                return shift.imag + height
            wanted *= 2

    def settle(self, nearest: Callable[[int], Disc], hint: complex, error: float) -> None:
        """Add discs around a hint until all is found that lies within its error."""
        wanted = FEW
        while not any(abs(hint - disc.shift) + error <= disc.radius for disc in self.discs):
            self.add(nearest(wanted))
            wanted *= 2

    @property
    def order(self) -> list[int]:
        """Numbers of the wanted ones among the values, that of largest real part first."""
        return sorted(range(len(self.values)), key=lambda k: -self.values[k].real)[: self.count]

    @property
    def found(self) -> list[tuple[complex, np.ndarray]]:
        """The wanted ones, (value, vector)."""
        return [(self.values[k], self.vectors[k]) for k in self.order]

    @property
    def edge(self) -> float:
        """The real part of the last eigenvalue that is wanted, of those found so far."""
        return self.values[self.order[-1]].real if self.values else self.start

    def slowest(self, low: float, high: float = math.inf) -> float:
        """The largest real part between two frequencies."""
        return max((value.real for value in self.values if low <= value.imag < high), default=-math.inf)


def rightmost(around: Around, start: float, count: int, sound: float) -> list[tuple[complex, np.ndarray]]:
    """(eigenvalue, vector) of the `count` eigenvalues of largest real part, that of largest real part first.

    A pair that oscillates counts as one. around: gives for a shift a function, which gives the disc of so many
    eigenvalues. start: a real shift, right of all that decays. sound: a frequency; oscillations are looked for up to it
    at least.
    """
    search = Search(count, start)
    reached, below = search.cover(around(start), complex(start), 0.0), 0.0
    while reached < sound or (math.inf > reached and search.slowest(below) >= search.slowest(SLOW * sound, below)):
        step = max(OVERLAP * (reached - below), SLOW * sound)
        shift = complex(0.5 * (search.edge + start), reached + step)
        reached, below = search.cover(around(shift), shift, reached), reached
    return search.found


def sharpened(around: Around, start: float, count: int, hints: list[complex]) -> list[tuple[complex, np.ndarray]]:
    """As `rightmost`, where the eigenvalues that oscillate are known roughly, from a coarser mesh."""
    search = Search(count, start)
    search.cover(around(start), complex(start), 0.0)
    for hint in hints:
        error = ROUGH * abs(hint)
        if hint.imag > 0.0 and hint.real + error > search.edge:
            search.settle(around(hint), hint, error)
    return search.found
