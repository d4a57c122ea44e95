"""What initial states have in common whose evolution is exactly known: that evolution, and when it holds."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from pydantic import Field

from hydro.initial.state import Condition, InitialState, MeanDensity
from hydro.mesh import Mesh
from hydro.schema import Number
from hydro.state import State

# Conserved fields, shape (4, nx, ny), averaged over the cells of a mesh, at a time.
Evolution = Callable[[Mesh, float], np.ndarray]


IDEAL = Condition("gas.K", lambda deck: deck.gas.K == 0.0, "must be 0")
ADIABATIC = Condition("gas.L", lambda deck: deck.gas.L == 0.0, "must be 0")
FRICTIONLESS = Condition("gas.tau", lambda deck: deck.gas.tau == math.inf, "must be inf")
PERIODIC = Condition("box.periodic", lambda deck: "x" in deck.box.periodic, 'must have "x"')
CLOSED = Condition("box.periodic", lambda deck: deck.box.periodic == (), "must be empty")
UNHEATED = Condition("wall.kind", lambda deck: deck.wall.kind == "elastic", "must be elastic")
GIVEN_HEAT = Condition(
    "wall.kind", lambda deck: deck.wall.kind in ("vibrating", "elastic"), "must be vibrating or elastic"
)
AT_REST = Condition("initial.velocity", lambda deck: deck.initial.velocity == (0.0, 0.0), "must be [0, 0]")


class ExactlyKnown(InitialState):
    """A state whose evolution is exactly known, if the deck fulfils `exact_if`."""

    def evolution(self, deck: Any) -> Evolution:
        """The evolution of a deck from this state."""
        raise NotImplementedError

    def state(self, deck: Any, gas: Any, mesh: Mesh) -> State:
        return State(gas, mesh, self.evolution(deck)(mesh, 0.0))


class Wave(ExactlyKnown, MeanDensity):
    """A wave along x in a gas of density f."""

    amplitude: Number = Field(default=0.1, gt=-1, lt=1, description="relative amplitude of the density")

    @property
    def largest(self) -> float:
        return abs(self.amplitude)


def straight(conserved: Callable[[np.ndarray, float], np.ndarray]) -> Callable[[np.ndarray, float], np.ndarray]:
    """(n, n u, e)(x, t) with nothing that moves along y."""
    return lambda x, t: np.insert(conserved(x, t), 2, 0.0, axis=0)


def along_x(conserved: Callable[[np.ndarray, float], np.ndarray]) -> Evolution:
    """The evolution of the conserved fields (x, t), averaged over cells."""
    from hydro.exact import cell_averages  # scipy is slow to import

    def averages(mesh: Mesh, t: float) -> np.ndarray:
        line = cell_averages(lambda x: conserved(x, t), mesh.x_faces)
        return np.repeat(line[:, :, None], mesh.cells[1], axis=2)

    return averages
