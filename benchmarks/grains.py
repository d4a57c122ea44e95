"""Speed and memory of the molecular dynamics: `python benchmarks/grains.py [rounds]` prints a table.

Collisions per second of processor time on one core. Of rounds of a second each, the best says what the machine can do,
the mean what it did while it had other work, too.
"""

from __future__ import annotations

import math
import sys
import time
from functools import cache

import numpy as np
from measure import processor

from hydro.gas import Grossman
from hydro.grains import books
from hydro.grains.cells import NARROWEST, arena
from hydro.grains.dynamics import EPOCH, Dynamics
from hydro.grains.placement import CLOSE_PACKING, placed
from hydro.grains.walls import ElasticWall
from hydro.markdown import table
from hydro.mesh import Mesh
from hydro.state import State
from hydro.steady.localized import steady_state
from hydro.walls import VibratingWall

NUMBERS = (20_000, 100_000, 1_000_000)
LONG = (20_000, 10_000_000)  # grains and collisions
WARM = 10.0  # diameters that a grain of temperature 1 flies before the measurement
ROUND = 1.0  # s


def uniform(number: int) -> Dynamics:
    """n = 0.3 everywhere."""
    return grains_of(State.of(Grossman(L=0.0, K=1.0), Mesh.rectangle((4, 4)), 0.3, 1.0), number)


def localized(number: int) -> Dynamics:
    """A cluster of n = 0.8 in a corner, in a gas of n = 0.004 at the same pressure; grains as in Fig. 4, Delta = 1."""
    gas, mesh = Grossman(L=0.0, K=1.0), Mesh.rectangle((64, 64))
    inside = (mesh.x[:, None] < 0.15) & (mesh.y[None, :] < 0.15)
    density = np.where(inside, 0.8, 0.004)
    pressure = gas.pressure(0.004, 1.0)
    return grains_of(State.of(gas, mesh, density, gas.temperature(density, pressure)), number)


@cache
def half_wave() -> State:
    """The localized state at f and L of Fig. 4."""
    mesh = Mesh.rectangle((64, 128), 2.0)
    return steady_state(Grossman(L=5e4, K=2e-3), VibratingWall(strength=0.228), mesh, 0.0235, 1).state


def steady(number: int) -> Dynamics:
    """The localized state at f and L of Fig. 4, Delta = 2."""
    return grains_of(half_wave(), number)


def in_equal_cells(number: int) -> Dynamics:
    """The same in cells as wide as a grain."""
    return grains_of(half_wave(), number, equal=True)


def grains_of(state: State, number: int, equal: bool = False) -> Dynamics:
    """So many elastic grains with the fields of a state."""
    diameter = math.sqrt(CLOSE_PACKING * state.mass / number)
    box, cell = arena(diameter, 1.0, state.mesh.aspect_ratio), NARROWEST * diameter if equal else None
    return Dynamics(box, ElasticWall(), *placed(state, number, diameter, seed=1), cell=cell)


STATES = {
    "uniform, n = 0.3": uniform,
    "localized, contrast 200": localized,
    "half-wave of Fig. 4": steady,
    "the same in equal cells": in_equal_cells,
}


def speeds(grains: Dynamics, rounds: int) -> np.ndarray:
    """Collisions per second in each of some rounds, when the fast grains have forgotten their start."""
    grains.advance(grains.time + WARM * grains.arena.diameter)
    span = 0.1 * grains.arena.diameter
    _, seconds = timed(grains, span)
    return np.array([np.divide(*timed(grains, span * ROUND / seconds)) for _ in range(rounds)])


def timed(grains: Dynamics, span: float) -> tuple[int, float]:
    """Collisions in a time, and the seconds that they took."""
    before, started = grains.count(books.COLLISIONS), time.process_time()
    grains.advance(grains.time + span)
    return grains.count(books.COLLISIONS) - before, time.process_time() - started


def bytes_per_grain(grains: Dynamics) -> float:
    """Of all arrays that the events use."""
    parts = grains.grains
    arrays = [*(part for part in parts if isinstance(part, np.ndarray)), parts.queue.pages]
    return sum(array.nbytes for array in arrays) / grains.number


def closest(number: int, collisions: int) -> float:
    """The smallest gap in the localized state, in diameters, over so many collisions."""
    grains, smallest = localized(number), math.inf
    while grains.count(books.COLLISIONS) < collisions:
        smallest = min(smallest, grains.closest_until(grains.time + EPOCH / 8, number))
    return smallest


def main(rounds: int) -> None:
    """Print the table, and the smallest gap in a long run."""
    rows = []
    for name, make in STATES.items():
        for number in NUMBERS:
            grains = make(number)
            rates = speeds(grains, rounds) / 1e6
            counts = grains.grains.counts / grains.count(books.COLLISIONS)
            rows.append([
                name, number, f"{rates.max():.2f}", f"{rates.mean():.2f}", f"{counts[books.CROSSINGS]:.2f}",
                f"{counts[books.STALE]:.2f}", f"{bytes_per_grain(grains):.0f}",
            ])  # fmt: skip
    header = ["state", "grains", "million collisions/s, best", "mean", "changes of cell", "stale events"]
    print(processor(), table([*header, "bytes per grain"], rows), sep="\n\n")
    print(f"\nsmallest gap between {LONG[0]} grains in {LONG[1]:g} collisions: {closest(*LONG):.2g} diameters")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5)
