"""Advancing a state to a time, for measurements: no output, no controller."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from hydro.dynamics.godunov import Godunov
from hydro.dynamics.integrator import Integrator
from hydro.errors import StepRejected
from hydro.gas import Grossman
from hydro.mesh import Mesh
from hydro.state import State
from hydro.walls import WALLS

IDEAL = Grossman(L=0.0, K=0.0)  # no conduction, no cooling
ELASTIC = WALLS["elastic"]()
ROUNDING = 1e-13
HALVINGS = 10


def godunov(mesh: Mesh, gas: Any = IDEAL, wall: Any = ELASTIC, **options: Any) -> Godunov:
    """A Godunov integrator, of ideal flow between elastic walls unless told otherwise."""
    return Godunov(gas, wall, mesh, **options)


def run(
    integrator: Integrator,
    state: State,
    end: float,
    dt: float | None = None,
    watch: Callable[[State], None] | None = None,
) -> dict[str, float]:
    """Advance `state` in place to the time `end`, with steps `dt` or the largest allowed, the last one shortened.

    `watch`, if given, sees the state after every step. Returns the energies exchanged, summed without rounding.
    """
    booked = []
    while end - state.time > ROUNDING * abs(end):
        largest = integrator.largest_step(state) if dt is None else dt
        booked.append(accepted(integrator, state, min(largest, end - state.time)))
        if watch is not None:
            watch(state)
    return {name: math.fsum(amounts[name] for amounts in booked) for name in booked[0]} if booked else {}


def accepted(integrator: Integrator, state: State, dt: float) -> dict[str, float]:
    """One step; a rejected one is tried again with half of it, down to a thousandth."""
    for _ in range(HALVINGS):
        try:
            return integrator.step(state, dt)
        except StepRejected:
            dt *= 0.5
    return integrator.step(state, dt)


def settle(
    integrator: Integrator, state: State, interval: float, tolerance: float, latest: float, dt: float | None = None
) -> float:
    """Advance until the density changes by less than `tolerance`, relative, over `interval`, or to time `latest`.

    Returns the last such change.
    """
    change = math.inf
    while change > tolerance and state.time < latest:
        before = state.density.copy()
        run(integrator, state, state.time + interval, dt)
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
