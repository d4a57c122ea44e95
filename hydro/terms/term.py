"""What a term of the equations says of itself."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Protocol, Self

import numpy as np

from hydro.accounts import Account

if TYPE_CHECKING:  # these wait for the compiler; a deck that names a term does not
    from hydro.gas import Closure
    from hydro.mesh import Faces, Mesh
    from hydro.state import State
    from hydro.walls.boundary import Boundary


class Stress(Protocol):
    """Stresses in a gas on a mesh, and the heat of them, as both kinds of integrator let them act."""

    def advance(self, state: np.ndarray, dt: float, spared: np.ndarray) -> None:
        """Let them act on the conserved `state` (4, nx, ny) for `dt`, at frozen density, but for cells `spared`.

        spared: their indices, (m, 2). Momentum and energy of all cells together are kept all the same.
        """

    def implicit(
        self, velocity: Faces, density: np.ndarray, pressure: np.ndarray, pushing: np.ndarray, h: float, drag: float,
        momentum: Faces, energy: np.ndarray,
    ) -> np.ndarray:  # fmt: skip
        """Let them act, implicitly, on the `momentum` of faces and the `energy` of cells over `h`; StepRejected.

        Returns the rate, (nx, ny), at which the flow becomes heat.

        velocity: a first guess. density, pressure: extrapolated, (nx, ny). pushing: the pressure under which velocities
        are found. drag: its rate. momentum: before pressure and drag act.
        """


class Term:
    """A term beside the flow of the gas and its heat. What a term does not say does not act.

    account: the entry of the ledger under which its energy is booked; None where it exchanges none.
    """

    account: Account | None = None

    @property
    def name(self) -> str:
        """What a limit of the step is called where steps are counted by what set them."""
        return type(self).__name__.lower()

    @classmethod
    def of(cls, deck: Any) -> Self | None:
        """The term as a deck has it; None where it has none."""
        return None

    def drag_rate(self) -> float:
        """The rate at which it slows the flow down, per scaled time; constant."""
        return 0.0

    def acceleration(self, time: float, state: State) -> np.ndarray | None:
        """Its force per mass on the gas, shape (2, nx, ny) for x and y, scaled."""
        return None

    def rates(self, time: float, mesh: Mesh) -> np.ndarray | None:
        """What it adds to the rates of the conserved fields, shape (4, nx, ny), scaled."""
        return None

    def stress(self, gas: Closure, boundary: Boundary, mesh: Mesh) -> Stress | None:
        """Its stresses, for a gas between walls on a mesh."""
        return None

    def largest_step(self, state: State) -> float:
        """The longest step that it allows."""
        return math.inf
