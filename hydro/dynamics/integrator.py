"""What the main loop asks of an integrator."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import ClassVar, Protocol

import numpy as np

from hydro.accounts import Account
from hydro.mesh import Mesh
from hydro.registry import Registry
from hydro.state import State

# What of its own may limit the step of an integrator of flow: sound or flow that crosses cells, and the error.
FLOW_LIMITS = ("sound", "remap", "error")

INTEGRATORS: Registry[Callable[..., Integrator]] = Registry("integrator")

# Rates of the four conserved fields, shape (4, nx, ny), at a time on a mesh, to be added to the equations.
Source = Callable[[float, Mesh], np.ndarray]


class StepRejected(Exception):
    """A step would leave the admissible states, and where; the state is as it was before."""


class Integrator(Protocol):
    """Advances a state; knows nothing of output, progress or files.

    accounts: the entries of the energy ledger that its steps fill. step_limits: names that `limits` may give.
    remembered: long name and unit of what `memory` gives, by name.
    """

    accounts: tuple[Account, ...] = ()
    step_limits: tuple[str, ...] = ()
    remembered: ClassVar[Mapping[str, tuple[str, str]]] = {}

    def limits(self, state: State) -> dict[str, float]:
        """The largest time steps that stability and accuracy allow from here, by names among `step_limits`."""

    def largest_step(self, state: State) -> float:
        """The least of the limits."""
        return min(self.limits(state).values())

    def step(self, state: State, dt: float) -> dict[str, float]:
        """Advance `state` in place by `dt`; returns the energies for the books, in n_c T_* L_x^2, by account.

        An account that the step has nothing for may be left out. StepRejected leaves the state untouched.
        """

    def work(self, steps: int) -> tuple[int, str]:
        """What `steps` steps have come to, and the unit: what the speed of a run is told in."""
        return steps, "steps"

    def memory(self) -> dict[str, np.ndarray]:
        """What has to be remembered, beside the state, to go on with the same bits; named as in `remembered`."""

    def remember(self, memory: dict[str, np.ndarray]) -> None:
        """Take back what `memory` gave."""
