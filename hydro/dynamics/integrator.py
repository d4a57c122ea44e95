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
    "steps": ("the last step, and the largest that the error allows for the next", "L_x/T_*^(1/2)"),
    "exchange": (
        "energy given by the wall, lost in collisions and by friction, from sources, in the last step",
        "n_c T_* L_x^2",
    ),
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

    def memory(self) -> dict[str, np.ndarray]:
        """What the integrator has to remember, beside the state, to go on with the same bits; named as in MEMORY."""

    def remember(self, memory: dict[str, np.ndarray]) -> None:
        """Take back what `memory` gave."""
