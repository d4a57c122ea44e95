"""Elastic grains between a reservoir of heat, 0 < x < DEPTH, of temperature 1 and a driving wall at x = 1.

Periodic in y. In the steady state all heat that the wall gives goes through the gas to the reservoir.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from hydro.grains import books, walls
from physics.bench import box_of_grains, redraw

DEPTH = 0.2  # of the reservoir
INTERVAL = 0.1  # between two looks, at which the reservoir draws velocities anew
BLOCKS = 10
BINS = 40

WALLS = {
    "random-phase": lambda speed, amplitude: walls.RandomPhaseWall(speed),
    "sinusoidal": lambda speed, amplitude: walls.SinusoidalWall(
        amplitude, speed / amplitude, 2.0 * math.pi * amplitude / speed
    ),
    "sawtooth": lambda speed, amplitude: walls.SawtoothWall(amplitude, 2.0 * math.pi * amplitude / speed),
    "thermal": lambda speed, amplitude: walls.ThermalWall(speed**2),
}


def slab(
    wall: str, speed: float, amplitude: float, n: float, number: int, length_y: float, warm: float, span: float,
    seed: int,
) -> dict[str, Any]:  # fmt: skip
    """Heat flux and profiles, averaged over blocks of time after `warm`.

    speed: A omega of a vibrating wall, T^(1/2) of a thermal one. Returns heat (blocks,), per area; counts (grains in a
    bin per look) and energies (sum of v^2/2), (blocks, bins); looks in a block.
    """
    random = np.random.default_rng([seed, 1])
    grains = box_of_grains(number, n, seed, WALLS[wall](speed, amplitude), 1.0, length_y, (False, True))
    looks = round(span / INTERVAL / BLOCKS)
    for _ in range(round(warm / INTERVAL)):
        step(grains, random)
    heat, counts, energies = [], [], []
    edges = np.linspace(0.0, 1.0, BINS + 1)
    for _ in range(BLOCKS):
        before, count, energy = grains.sum(books.WALL_ENERGY), np.zeros(BINS), np.zeros(BINS)
        for _ in range(looks):
            step(grains, random)
            x, kinetic = grains.positions[:, 0], 0.5 * (grains.velocities**2).sum(axis=1)
            count += np.histogram(x, edges)[0]
            energy += np.histogram(x, edges, weights=kinetic)[0]
        heat.append((grains.sum(books.WALL_ENERGY) - before) / (looks * INTERVAL * length_y))
        counts.append((count / looks).tolist())
        energies.append((energy / looks).tolist())
    return {"heat": heat, "counts": counts, "energies": energies, "diameter": grains.arena.diameter}


def step(grains: Any, random: np.random.Generator) -> None:
    """To the next look."""
    grains.advance(grains.time + INTERVAL)
    redraw(grains, DEPTH, random)
