"""What the main loop asks of an integrator."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np

from hydro.accounts import COLLISIONS, FRICTION, INTERNAL, SOURCE, WALL, Account
from hydro.state import State
from hydro.terms import Terms

# What of its own may limit the step of an integrator of flow: sound or flow that crosses cells, and the error.
FLOW_LIMITS = ("sound", "remap", "error")


def flow_accounts(terms: Terms) -> tuple[Account, ...]:
    """The accounts of an integrator of flow: those that every run has, and those of further terms."""
    return tuple(dict.fromkeys((WALL, COLLISIONS, FRICTION, SOURCE, INTERNAL, *terms.accounts)))


def flow_limits(terms: Terms) -> tuple[str, ...]:
    """What may limit its steps."""
    return (*FLOW_LIMITS, *terms.limiting)


class Remedy(NamedTuple):
    """What has helped runs that no step was possible for."""

    change: str  # of the deck, as on the command line
    is_new: Callable[[Any], bool]  # whether a deck is not like that already


class Integrator(Protocol):
    """Advances a state; knows nothing of output, progress or files.

    accounts: the entries of the energy ledger that its steps fill. step_limits: names that `limits` may give.
    remembered: long name and unit of what `memory` gives, by name. remedies: what has been tried, and has helped, where
    its steps got shorter and shorter, the most helpful first.
    """

    accounts: tuple[Account, ...] = ()
    step_limits: tuple[str, ...] = ()
    remembered: ClassVar[Mapping[str, tuple[str, str]]] = {}
    remedies: ClassVar[tuple[Remedy, ...]] = ()

    # Guesses for decks of evolution, good to a factor of two or three on one core of a current processor.
    seconds_per_cell_step: ClassVar[float] = 1e-7
    bytes_per_cell: ClassVar[int] = 200  # of state and work space, without viscosity

    @staticmethod
    def options(deck: Any) -> dict[str, Any]:
        """What it takes of a deck beside gas, wall, mesh and terms."""
        return {}

    @staticmethod
    def expected_steps(deck: Any, by_sound: float) -> tuple[float, str]:
        """How many steps a deck takes, and what that is known by; `by_sound`: those that sound asks for."""
        return by_sound, "about, with the sound speed of the start or of the driving wall"

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

    def counts(self) -> dict[str, int]:
        """How often something out of the ordinary was done so far, by name, for history and summary."""
        return {}

    def resolution(self) -> dict[str, Any]:
        """What the summary says of sound: whether the steps so far have resolved it."""
        return {"sound_resolved": True}

    def memory(self) -> dict[str, np.ndarray]:
        """What has to be remembered, beside the state, to go on with the same bits; named as in `remembered`."""

    def remember(self, memory: dict[str, np.ndarray]) -> None:
        """Take back what `memory` gave."""
