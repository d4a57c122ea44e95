"""The driving wall at x = 1, as grains meet it.

Each wall says how long it takes until a grain that flies freely meets it, and with what velocity the grain leaves. A
wall that moves has a period; `time` is counted from the beginning of one. Walls act on the centres of grains. Units:
length L_x, velocity T_*^(1/2).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from hydro.grains.random import normal, rayleigh, uniform
from hydro.jit import inline
from hydro.methods import compiled_methods

NEVER = math.inf
FASTEST_GRAZE = 1e-9  # of the wall's speed: a grain leaves the wall at this speed or more, relative to it
ROUNDS = 200  # of the search for a root, which needs some five


@inline(exact=True)
def meeting_at_rest(x, v):
    """Time until a grain meets a wall at rest."""
    return max(1.0 - x, 0.0) / v if v > 0.0 else NEVER


@compiled_methods(exact=True)
class ElasticWall(NamedTuple):
    """A wall at rest that reflects."""

    period: float = 1.0

    def meeting(self, x, v, time):
        """Time until a grain at x with normal velocity v at `time` meets the wall; infinite if never."""
        return meeting_at_rest(x, v)

    def rebound(self, vx, vy, time, random):
        """Velocity of a grain after it has met the wall."""
        return -vx, vy


@compiled_methods(exact=True)
class ThermalWall(NamedTuple):
    """Grains leave with the flux of a Maxwellian."""

    temperature: float
    period: float = 1.0

    def meeting(self, x, v, time):
        """As for the elastic wall."""
        return meeting_at_rest(x, v)

    def rebound(self, vx, vy, time, random):
        """Normal velocity distributed as v exp(-v^2/2T), the other as a Gaussian."""
        speed = math.sqrt(self.temperature)
        return -speed * rayleigh(random), speed * normal(random)


@compiled_methods(exact=True)
class RandomPhaseWall(NamedTuple):
    """The limit of small amplitude: at rest, but its velocity at an impact is that of a sinusoidal wall, u cos(phase).

    Phases are as likely as the grain is fast relative to the wall: those at which it would meet a wall that moves.
    """

    speed: float  # A omega
    period: float = 1.0

    def meeting(self, x, v, time):
        """As for the elastic wall."""
        return meeting_at_rest(x, v)

    def rebound(self, vx, vy, time, random):
        """Elastic impacts on the moving wall, until the grain leaves."""
        while vx >= 0.0:
            wall = self.speed * math.cos(2.0 * math.pi * uniform(random))
            if uniform(random) * (vx + self.speed) < vx - wall:
                vx = 2.0 * wall - vx
        return vx, vy


@compiled_methods(exact=True)
class SinusoidalWall(NamedTuple):
    """The wall itself, at 1 + A cos(omega time)."""

    amplitude: float
    omega: float
    period: float

    def meeting(self, x, v, time):
        """The first root of the gap between wall and grain.

        The gap bends by A omega^2 at most, so a parabola bent as strongly lies below it: where that one closes, the
        gap is still open or just closing. Going from root to root of such parabolas leads to the first root of the
        gap and never beyond it, however often the grain meets the wall in a period.
        """
        if x < 1.0 - self.amplitude:
            if v <= 0.0:
                return NEVER
            start = (1.0 - self.amplitude - x) / v
        else:
            start = 0.0
        bend = self.amplitude * self.omega * self.omega
        elapsed = start
        for _ in range(ROUNDS):
            phase = self.omega * (time + elapsed)
            gap = 1.0 + self.amplitude * math.cos(phase) - (x + v * elapsed)
            opening = -self.amplitude * self.omega * math.sin(phase) - v
            if gap <= 0.0 and opening <= 0.0:
                return elapsed
            step = (opening + math.sqrt(max(opening * opening + 2.0 * bend * gap, 0.0))) / bend
            elapsed += step
            if v <= 0.0 and (x + v * elapsed < 1.0 - self.amplitude or elapsed > start + self.period):
                return NEVER
            if step <= 1e-16 * self.period:
                return elapsed
        return elapsed

    def rebound(self, vx, vy, time, random):
        """An elastic impact; a grain that grazes the wall leaves it slowly, but leaves."""
        wall = -self.amplitude * self.omega * math.sin(self.omega * time)
        least = FASTEST_GRAZE * self.amplitude * self.omega
        return wall - max(vx - wall, least), vy


@compiled_methods(exact=True)
class SawtoothWall(NamedTuple):
    """Moves from 1 + A to 1 - A at constant speed, and is back at once."""

    amplitude: float
    period: float

    def meeting(self, x, v, time):
        """The first of the teeth that the grain meets."""
        speed = 2.0 * self.amplitude / self.period
        near = 1.0 - self.amplitude
        if x < near and v <= 0.0:
            return NEVER
        elapsed = max(near - x, 0.0) / v if x < near else 0.0
        begin = math.floor((time + elapsed) / self.period) * self.period - time
        while x + v * max(begin, 0.0) >= near or v > 0.0:
            met = (1.0 + self.amplitude + speed * begin - x) / (v + speed) if v + speed > 0.0 else NEVER
            met = max(met, max(begin, 0.0))
            if met < begin + self.period:
                return met
            begin += self.period
        return NEVER

    def rebound(self, vx, vy, time, random):
        """An elastic impact on a wall that always comes."""
        speed = 2.0 * self.amplitude / self.period
        return -max(vx + speed, FASTEST_GRAZE * speed) - speed, vy
