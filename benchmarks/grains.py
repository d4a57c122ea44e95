"""Speed and memory of the molecular dynamics: `python benchmarks/grains.py [rounds]` prints a table.

Collisions per second of processor time on one core, the best of some rounds: neighbours on a busy machine only slow.
"""

from __future__ import annotations

import math
import sys
import time

import numpy as np
from measure import processor, table

from hydro.gas import Grossman
from hydro.grains import events
from hydro.grains.dynamics import Dynamics, arena
from hydro.grains.placement import CLOSE_PACKING, placed
from hydro.grains.walls import ElasticWall
from hydro.mesh import Mesh
from hydro.state import State

COLLISIONS_PER_GRAIN = 10.0  # in a round


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


def grains_of(state: State, number: int) -> Dynamics:
    """So many elastic grains with the fields of a state."""
    diameter = math.sqrt(CLOSE_PACKING * state.mass / number)
    return Dynamics(arena(diameter, 1.0, 1.0, number), ElasticWall(), *placed(state, number, diameter, seed=1))


def speed(grains: Dynamics, rounds: int) -> float:
    """Collisions per second."""
    span, best = 1e-3 * grains.arena.diameter, 0.0
    while (before := grains.count(events.COLLISIONS)) < grains.number:
        grains.advance(grains.time + span)
        rate = (grains.count(events.COLLISIONS) - before) / span
        span = max(span, 0.5 * COLLISIONS_PER_GRAIN * grains.number / max(rate, 1.0) * 0.2)
    for _ in range(rounds):
        before, started = grains.count(events.COLLISIONS), time.process_time()
        grains.advance(grains.time + span)
        best = max(best, (grains.count(events.COLLISIONS) - before) / (time.process_time() - started))
    return best


def bytes_per_grain(grains: Dynamics) -> float:
    """Of all arrays that the events use."""
    parts = grains.grains
    arrays = [parts.motion, parts.links, parts.heads, *parts.queue]
    return sum(array.nbytes for array in arrays) / grains.number


def main(rounds: int) -> None:
    """Print the table."""
    rows = []
    for name, make, number in (
        ("uniform, n = 0.3", uniform, 2_000), ("uniform, n = 0.3", uniform, 20_000),
        ("uniform, n = 0.3", uniform, 200_000), ("localized, contrast 200", localized, 20_000),
    ):  # fmt: skip
        grains = make(number)
        rate = speed(grains, rounds)
        counts = grains.grains.counts
        per_collision = f"{counts[events.CROSSINGS] / counts[0]:.2f}", f"{counts[events.STALE] / counts[0]:.2f}"
        rows.append([name, number, f"{rate / 1e6:.3g}", *per_collision, f"{bytes_per_grain(grains):.0f}"])
    header = ["state", "grains", "million collisions/s", "changes of cell", "stale events", "bytes per grain"]
    print(processor(), table(header, rows), sep="\n\n")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5)
