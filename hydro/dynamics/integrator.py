"""What the main loop asks of an integrator."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np

from hydro.mesh import Mesh
from hydro.registry import Registry
from hydro.state import State

# What of an integrator's own may limit its step: sound that crosses cells, flow that crosses cells, and the error.
STEP_LIMITS = ("sound", "remap", "error")

# Long name and unit of what integrators remember.
MEMORY = {
    "wall_temperature": ("temperature of the driving wall, first guess of the next", "T_*"),
    "last": ("fields at the step before: density, momentum along x and y, energy", "n_c, n_c T_*^(1/2), n_c T_*"),
    "momentum": ("momentum density of faces in x and y, now and at the step before", "n_c T_*^(1/2)"),
    "velocity": ("velocity of faces in x and y, extrapolated", "T_*^(1/2)"),
    "missed": ("what the last extrapolation missed of pressure and temperature", "n_c T_*, T_*"),
    "span": ("product of the steps of that extrapolation", "L_x^2/T_*"),
    "steps": ("the last step, and the largest that the error allows for the next", "L_x/T_*^(1/2)"),
    "exchange": (
        "energy given by the wall, lost in collisions and by friction, from sources, in the last step",
        "n_c T_* L_x^2",
    ),
    "motion": (
        "of grains: x, y, velocities along x and y, and the time they belong to, since the epoch",
        "L_x, T_*^(1/2), L_x/T_*^(1/2)",
    ),
    "epoch": ("number of the quarter of a time unit that times of grains are counted from", "1"),
    "clock": ("time of the last event since the epoch, and of the epoch in the period of the wall", "L_x/T_*^(1/2)"),
    "random": ("state of the random numbers", "1"),
    "sums": (
        "energy from the wall, lost in collisions, virial, momentum to the walls x = 0 and x = 1",
        "a grain's mass times T_* or T_*^(1/2)",
    ),
    "counts": ("collisions, impacts on the driving wall, soft collisions, stale events, changes of cell", "1"),
    "time": ("time of the grains", "L_x/T_*^(1/2)"),
    "look_times": ("times of the looks that averages are taken over", "L_x/T_*^(1/2)"),
    "look_fields": ("fields of these looks: density, momentum along x and y, energy", "n_c, n_c T_*^(1/2), n_c T_*"),
    "look_virials": ("the virial at these looks", "a grain's mass times T_*"),
}

INTEGRATORS: Registry[Callable[..., Integrator]] = Registry("integrator")

# Rates of the four conserved fields, shape (4, nx, ny), at a time on a mesh, to be added to the equations.
Source = Callable[[float, Mesh], np.ndarray]


class StepRejected(Exception):
    """A step would leave the admissible states, and where; the state is as it was before."""


class Exchange(NamedTuple):
    """Energy that crossed the system's border in one step, or was lost in it."""

    wall: float = 0.0  # given by the driving wall
    collisions: float = 0.0  # lost in collisions
    friction: float = 0.0  # of the flow, lost by rolling friction
    source: float = 0.0  # given by an added source term


class Integrator(Protocol):
    """Advances a state; knows nothing of output, progress or files."""

    def limits(self, state: State) -> dict[str, float]:
        """The largest time steps that stability and accuracy allow from here, by names among STEP_LIMITS."""

    def largest_step(self, state: State) -> float:
        """The least of the limits."""
        return min(self.limits(state).values())

    def step(self, state: State, dt: float) -> Exchange:
        """Advance `state` in place by `dt`; StepRejected leaves it untouched."""

    def work(self, steps: int) -> tuple[int, str]:
        """What `steps` steps have come to, and the unit: what the speed of a run is told in."""
        return steps, "steps"

    def memory(self) -> dict[str, np.ndarray]:
        """What the integrator has to remember, beside the state, to go on with the same bits; named as in MEMORY."""

    def remember(self, memory: dict[str, np.ndarray]) -> None:
        """Take back what `memory` gave."""
