"""Whether the steps of the implicit integrator resolve the sound that is there.

Sound that is not resolved dies by the scheme, and the tolerance, which is relative to the mean state, does not see
sound that is smaller than itself. In sound |dp| is about n c |u|; in slow flow dp is of second order in the Mach
number, and gas that a force holds has dp without u: so both are told from it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hydro.fields import MX, MY, N
from hydro.jit import kernel
from hydro.mesh import Mesh
from hydro.state import State

ALIKE = 10.0  # factor by which |dp| and n c |u| may differ in sound
LEAST = 1e-7  # amplitude that round-off of the pressures could make
RESOLVED = 20.0  # steps in a period: the backward difference takes (2 pi)^4/4/20^3 = 5% of the sound in one


class Sound(NamedTuple):
    """What is there: amplitude (root mean square of dp over n c^2, of u over c, the larger one; 0 for none), period."""

    amplitude: float
    period: float  # of the slowest sound of the box, at the mean speed of sound

    @classmethod
    def of(cls, state: State) -> Sound:
        """That of a state."""
        sound = state.gas.sound_speed(state.density, state.temperature)
        return cls.measured(state.mesh, state.conserved, state.pressure, sound)

    @classmethod
    def measured(cls, mesh: Mesh, conserved: np.ndarray, pressure: np.ndarray, sound: np.ndarray) -> Sound:
        """That of a state whose pressure and sound speed are known, (nx, ny) each."""
        push, mach, speed = amplitudes(mesh.dx, mesh.dy, conserved, pressure, sound)
        alike = push < ALIKE * mach and mach < ALIKE * push and min(push, mach) > LEAST
        sides = ((1.0, mesh.periodic[0]), (mesh.aspect_ratio, mesh.periodic[1]))
        longest = max(length if periodic else 2.0 * length for length, periodic in sides)
        return cls(max(push, mach) if alike else 0.0, longest / speed)


class Unresolved:
    """The sound of a run that its steps did not resolve."""

    def __init__(self) -> None:
        # Its largest amplitude (zero: none), the fewest steps in a period, the shortest period.
        self.memory = np.zeros(3)

    def note(self, sound: Sound, dt: float) -> None:
        """A step of `dt` from a state with this sound."""
        steps = sound.period / dt
        if sound.amplitude > 0.0 and steps < RESOLVED:
            largest, fewest, shortest = self.memory if self.memory[0] > 0.0 else (0.0, math.inf, math.inf)
            self.memory[:] = max(largest, sound.amplitude), min(fewest, steps), min(shortest, sound.period)

    def summary(self) -> dict[str, float | bool]:
        """For summaries."""
        amplitude, steps, period = map(float, self.memory)
        if amplitude == 0.0:
            return {"sound_resolved": True}
        return {
            "sound_resolved": False,
            "unresolved_sound": amplitude,
            "steps_per_sound_period": steps,
            "dt_for_sound": resolving_step(period),
        }


def resolving_step(period: float) -> float:
    """A step that resolves sound of this period, and of one that is a fifth shorter, as sound in hotter gas is."""
    return 0.8 * period / RESOLVED


def foreseen_steps(amplitude: float, tolerance: float) -> float:
    """Steps in a period that the tolerance makes of sound: changes of (omega dt)^2 times its amplitude are allowed."""
    return 2.0 * math.pi * math.sqrt(amplitude / tolerance)


@kernel(exact=True)
def amplitudes(dx, dy, conserved, pressure, sound):
    """Root mean squares of the deviation of pressure over n c^2 and of velocity over sound; the mean sound speed."""
    area, mean, stiffness, speed = 0.0, 0.0, 0.0, 0.0
    for i in range(dx.size):
        for j in range(dy.size):
            cell, c = dx[i] * dy[j], sound[i, j]
            area += cell
            mean += cell * pressure[i, j]
            stiffness += cell * conserved[N, i, j] * c * c
            speed += cell * c
    mean, push, flow = mean / area, 0.0, 0.0
    for i in range(dx.size):
        for j in range(dy.size):
            cell, n, c = dx[i] * dy[j], conserved[N, i, j], sound[i, j]
            u, v = conserved[MX, i, j] / (n * c), conserved[MY, i, j] / (n * c)
            push += cell * (pressure[i, j] - mean) ** 2
            flow += cell * (u * u + v * v)
    return np.sqrt(push * area) / stiffness, np.sqrt(flow / area), speed / area
