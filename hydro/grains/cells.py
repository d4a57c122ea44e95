"""Cells that say where to look for grains: as wide as a grain or wider, from border to border along x and along y.

What happens to the grains does not depend on them, only how long it takes to find out.
"""

from __future__ import annotations

import math

import numpy as np

from hydro.grains.state import Arena

NARROWEST = 1.01  # diameters
BLOCK = 32.0  # diameters: width of the blocks in which cells are equal
OCCUPANCY = 0.3  # grains in a cell, where that asks for no narrower ones


def arena(
    diameter: float,
    restitution: float,
    length_y: float,
    periodic: tuple[bool, bool] = (False, False),
    contact_time: float = 0.0,
) -> Arena:
    """The box 0 < x < 1, 0 < y < length_y of the centres of grains, as yet in as few cells as there may be.

    ValueError where a periodic box has no room for three cells across.
    """
    for along, length in zip(periodic, (1.0, length_y), strict=True):
        room = math.floor(length / (NARROWEST * diameter))
        if along and room < 3:
            raise ValueError(
                f"a periodic box must be three cells wide, and grains of diameter {diameter:g} leave {room}"
            )
    columns, rows = (fewest(along) for along in periodic)
    borders_x, borders_y = np.linspace(0.0, 1.0, columns + 1), np.linspace(0.0, length_y, rows + 1)
    box = (float(diameter), restitution, contact_time, length_y, *periodic)
    return Arena(*box, columns, rows, borders_x, borders_y)


def fewest(periodic: bool) -> int:
    """The least number of cells along a direction."""
    return 3 if periodic else 1


def divided(box: Arena, borders_x: np.ndarray, borders_y: np.ndarray) -> Arena:
    """The box with these cells."""
    columns, rows = len(borders_x) - 1, len(borders_y) - 1
    return box._replace(columns=columns, rows=rows, borders_x=borders_x, borders_y=borders_y)


def equal(box: Arena, width: float) -> Arena:
    """The box in equal cells of a width, or a little more; along a periodic direction in three at least."""
    directions = ((1.0, box.periodic_x), (box.length_y, box.periodic_y))
    numbers = (max(math.floor(length / width), fewest(periodic)) for length, periodic in directions)
    borders = (np.linspace(0.0, length, n + 1) for (length, _), n in zip(directions, numbers, strict=True))
    return divided(box, *borders)


def crowded(box: Arena, places: np.ndarray, reach: float = 0.0) -> Arena:
    """The box in cells that are narrow where its grains, at `places` (N, 2), are crowded, and wide where they fly far.

    Columns and rows go through the whole box; what counts in each is how crowded it is where its grains are. The last
    column holds all of what a moving wall can `reach`, 1-reach < x: only there grains look for it.
    """
    lengths = np.array([1.0, box.length_y])
    blocks = np.maximum(lengths / (BLOCK * box.diameter), 1.0).astype(int)
    block_x, block_y = np.clip(places * blocks / lengths, 0, blocks - 1).astype(int).T
    counts = np.bincount(block_x * blocks[1] + block_y, minlength=blocks.prod()).reshape(blocks)
    borders_x = graded(box, counts, 1.0, box.length_y, fewest(box.periodic_x))
    borders_y = graded(box, counts.T, box.length_y, 1.0, fewest(box.periodic_y))
    beside = (borders_x > 1.0 - 1.001 * reach) & (borders_x < 1.0)
    return divided(box, borders_x[~beside], borders_y)


def graded(box: Arena, counts: np.ndarray, length: float, across: float, least: int) -> np.ndarray:
    """Borders of cells along a `length`, from the counts of grains in blocks along and across it; `least` or more."""
    width, area = length / len(counts), length * across / counts.size
    seen = (counts**2).sum(axis=1) / np.maximum(counts.sum(axis=1), 1)  # by a grain, of its own block
    wanted = np.sqrt(OCCUPANCY * area / np.maximum(seen, OCCUPANCY))
    cells = np.maximum(width / np.maximum(wanted, NARROWEST * box.diameter), math.ceil(least / len(counts))).astype(int)
    inner = [width * (block + np.arange(one) / one) for block, one in enumerate(cells)]
    return np.append(np.concatenate(inner), length)


def inside(box: Arena, places: np.ndarray) -> np.ndarray:
    """Column and row of the cells that places are in, (N, 2); of the nearest, for what is outside."""
    column, row = (
        np.clip(np.searchsorted(borders, along, side="right") - 1, 0, len(borders) - 2)
        for borders, along in zip((box.borders_x, box.borders_y), places.T, strict=True)
    )
    return np.stack([column, row], axis=1).astype(np.int32)
