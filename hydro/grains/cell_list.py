"""The cell list: which grains are in a cell, and which cells are near.

A periodic box is surrounded by images of itself: a column or row beyond its border is one of the other side.
"""

from __future__ import annotations

import numpy as np

from hydro.grains.queue import NOBODY, aligned
from hydro.grains.state import ACROSS_X, ACROSS_Y, CANDIDATE, CELL, Arena
from hydro.jit import inline, kernel


@inline(exact=True)
def around(cell, cells):
    """How often one goes round a periodic box to a cell beyond its border: -1, 0 or 1."""
    return (cell >= cells) - (cell < 0)


@inline(exact=True)
def wrapped(cell, cells):
    """A cell beyond the border of a periodic box, counted inside it."""
    return cell - around(cell, cells) * cells


@inline(exact=True)
def cell_at(arena, column, row):
    """The index of a cell: blocks of 2 x 4 cells have a line of the cache each."""
    blocks = (arena.rows + 3) >> 2
    return np.uintp((((column >> 1) * blocks + (row >> 2)) << 3) + ((column & 1) << 2) + (row & 3))


def no_cells(arena: Arena) -> np.ndarray:
    """Room for the cells of a box."""
    return aligned(int(cell_at.py_func(arena, arena.columns - 1 | 1, arena.rows - 1 | 3)) + 1, CELL)


@inline(exact=True)
def neighbours(cell, cells, periodic):
    """First and last of the cells around one, along one direction. Beyond the last come, if periodic, the first."""
    if periodic:
        return cell - 1, cell + 1
    return max(cell - 1, 0), min(cell + 1, cells - 1)


@inline(exact=True)
def new_neighbours(cell, cells, periodic, step):
    """Of the cells around one, along one direction, first and last of those that a step into it has brought near."""
    first, last = neighbours(cell, cells, periodic)
    return (cell + 1 if step > 0 else first), (cell - 1 if step < 0 else last)


@inline(exact=True)
def gather(grains, arena, first_column, last_column, first_row, last_row):
    """List the grains in a block of cells as candidates; returns how many there are.

    What is written behind the last candidate is written over.
    """
    cells, motion, candidates = grains.cells, grains.motion, grains.candidates
    found = 0
    for column in range(first_column, last_column + 1):
        across_x = around(column, arena.columns)
        for row in range(first_row, last_row + 1):
            across_y = around(row, arena.rows)
            cell = cell_at(arena, column - across_x * arena.columns, row - across_y * arena.rows)
            candidates[found, CANDIDATE] = cells[cell].first
            candidates[found, ACROSS_X] = across_x
            candidates[found, ACROSS_Y] = across_y
            found += cells[cell].first >= 0
            other = cells[cell].second
            while other >= 0:
                candidates[found, CANDIDATE] = other
                candidates[found, ACROSS_X] = across_x
                candidates[found, ACROSS_Y] = across_y
                found += 1
                other = motion[np.uintp(other)].following
    return found


@inline(exact=True)
def leave_cell(grains, arena, i):
    """Take grain i out of its cell."""
    cells, motion = grains.cells, grains.motion
    cell = cell_at(arena, motion[i].column, motion[i].row)
    before = np.int64(cells[cell].second)
    if cells[cell].first == i:
        cells[cell].first = before
        if before >= 0:
            cells[cell].second = motion[before].following
    elif before == i:
        cells[cell].second = motion[i].following
    else:
        while motion[before].following != i:
            before = np.int64(motion[before].following)
        motion[before].following = motion[i].following


@inline(exact=True)
def enter_cell(grains, arena, i, column, row):
    """Put grain i into a cell, as the first or else the second."""
    cells, motion = grains.cells, grains.motion
    cell = cell_at(arena, column, row)
    motion[i].column, motion[i].row = column, row
    if cells[cell].first < 0:
        cells[cell].first = i
    else:
        motion[i].following = cells[cell].second
        cells[cell].second = i


@kernel(exact=True)
def fill_cells(grains, arena, cells):
    """Put every grain into its cell, given by column and row, shape (N, 2)."""
    for cell in range(grains.cells.size):
        grains.cells[cell].first, grains.cells[cell].second = NOBODY, NOBODY
    for i in range(len(cells)):
        enter_cell(grains, arena, i, cells[i, 0], cells[i, 1])
