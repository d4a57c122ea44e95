"""What measurements have in common: integrators, meshes, steps of one size, norms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from hydro.driver.march import march
from hydro.dynamics.godunov import Godunov
from hydro.dynamics.integrator import Integrator
from hydro.gas import Grossman
from hydro.mesh import Mesh
from hydro.state import State
from hydro.walls import ElasticWall

IDEAL = Grossman(L=0.0, K=0.0)  # no conduction, no cooling
ELASTIC = ElasticWall()
ROUNDING = 1e-12  # relative, of sums of steps


def godunov(mesh: Mesh, gas: Any = IDEAL, wall: Any = ELASTIC, **options: Any) -> Godunov:
    """A Godunov integrator, of ideal flow between elastic walls unless told otherwise."""
    return Godunov(gas, wall, mesh, **options)


class FixedSteps(Integrator):
    """An integrator that takes steps of `dt`, whatever it would choose."""

    step_limits = ("fixed",)

    def __init__(self, integrator: Integrator, dt: float):
        self.integrator, self.accounts = integrator, integrator.accounts
        self.dt = dt * (1.0 + ROUNDING)  # so that the last step is no longer than the others, nor a sliver

    def limits(self, state: State) -> dict[str, float]:
        return {"fixed": self.dt}

    def step(self, state: State, dt: float) -> dict[str, float]:
        return self.integrator.step(state, dt)

    def memory(self) -> dict[str, np.ndarray]:
        return self.integrator.memory()

    def remember(self, memory: dict[str, np.ndarray]) -> None:
        self.integrator.remember(memory)


def stepping(integrator: Integrator, dt: float | None) -> Integrator:
    """The integrator with steps of `dt`; as it is without."""
    return integrator if dt is None else FixedSteps(integrator, dt)


def settle(
    integrator: Integrator, state: State, interval: float, tolerance: float, latest: float, dt: float | None = None
) -> float:
    """Advance until the density changes by less than `tolerance`, relative, over `interval`, or to time `latest`.

    Returns the last such change.
    """
    change = math.inf
    while change > tolerance and state.time < latest:
        before = state.density.copy()
        march(state, stepping(integrator, dt), state.time + interval)
        change = float(np.max(np.abs(state.density / before - 1.0)))
    return change


def l1(mesh: Mesh, error: np.ndarray) -> float:
    """Mean of |error| over the box."""
    return mesh.integral(np.abs(error)) / mesh.aspect_ratio


def along(axis: int, count: int, thickness: int = 1, periodic: bool = True) -> Mesh:
    """A unit box of `count` cells along `axis` and `thickness` across, periodic across."""
    cells, sides = ((count, thickness), (periodic, True)) if axis == 0 else ((thickness, count), (True, periodic))
    return Mesh.rectangle(cells, periodic=sides)


def laid(axis: int, line: np.ndarray, thickness: int = 1) -> np.ndarray:
    """Fields on a line (..., count) as fields on the mesh `along` that axis."""
    spread = np.repeat(line[..., None], thickness, axis=-1)
    return spread if axis == 0 else np.swapaxes(spread, -1, -2)
