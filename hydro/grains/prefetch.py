"""Memory brought near before it is needed: the grains and cells that the events of the coming days are about.

None of this changes a result.
"""

from __future__ import annotations

import numpy as np

from hydro.grains.cell_list import cell_at, neighbours, wrapped
from hydro.grains.prediction import cells_to_search
from hydro.grains.queue import day_of, first_on, page_of, put
from hydro.jit import fetch, inline

TO_FIRST, TO_SECOND, TO_ALL = 14, 11, 8  # days to that whose first, second grain is fetched; all are looked at
LAG = 2  # events between two looks at a grain, a power of two


@inline(exact=True)
def fetch_grain(grains, i):
    """Have all that is known of a grain brought near."""
    fetch(grains.motion, i)
    fetch(grains.prospects, i)


@inline(exact=True)
def collides(grains, i):
    """Whether the next event of grain i is a collision with another, if that has not changed its course."""
    prospects = grains.prospects
    return (prospects[i].partner >= 0) & (prospects[i].event == prospects[i].collision)


@inline(exact=True)
def neighbours_of_both(cell, other, cells, periodic):
    """First and last of the cells around two cells side by side, along one direction; of two far apart, around one."""
    (first, _), (_, last) = neighbours(min(cell, other), cells, periodic), neighbours(max(cell, other), cells, periodic)
    return first, min(last, first + 3)


@inline(exact=True)
def cells_around_both(grains, arena, i):
    """The cells around grain i, and around its partner or the cell that its next event takes it to; as from
    `cells_to_search`."""
    motion, prospects = grains.motion, grains.prospects
    column, row = motion[i].column, motion[i].row
    other_column, other_row = column + prospects[i].step_x, row + prospects[i].step_y
    if collides(grains, i):
        partner = np.int64(prospects[i].partner)
        other_column, other_row = motion[partner].column, motion[partner].row
    first_column, last_column = neighbours_of_both(column, other_column, arena.columns, arena.periodic_x)
    first_row, last_row = neighbours_of_both(row, other_row, arena.rows, arena.periodic_y)
    return first_column, last_column, first_row, last_row


@inline(exact=True)
def cells_to_search_next(grains, arena, i):
    """The cells that grain i looks into after its next event."""
    motion, prospects = grains.motion, grains.prospects
    return cells_to_search(
        grains, arena, i, motion[i].column + prospects[i].step_x, motion[i].row + prospects[i].step_y
    )


@inline(exact=True)
def fetch_cells(grains, arena, i):
    """Have the cells brought near that the next event of grain i is about, and the page of that of its partner.

    Beyond the border of a periodic box they are not the right ones, which does no harm.
    """
    first_column, last_column, first_row, last_row = cells_around_both(grains, arena, i)
    for column in (first_column, first_column + 2, last_column):
        fetch(grains.cells, cell_at(arena, column, first_row))
        fetch(grains.cells, cell_at(arena, column, last_row))
    queue, partner = grains.queue, max(np.int64(grains.prospects[i].partner), 0)
    fetch(queue.pages, page_of(queue, day_of(queue, grains.prospects[partner].event)))


@inline(exact=True)
def fetch_neighbours(grains, arena, i):
    """Have the grains brought near that are looked at after the next event of grain i: the first two of each cell."""
    if collides(grains, i):
        queue, partner = grains.queue, np.int64(grains.prospects[i].partner)
        fetch(grains.prospects, first_on(queue, day_of(queue, grains.prospects[partner].event)))
        first_column, last_column, first_row, last_row = cells_around_both(grains, arena, i)
    else:
        first_column, last_column, first_row, last_row = cells_to_search_next(grains, arena, i)
    for column in range(first_column, last_column + 1):
        for row in range(first_row, last_row + 1):
            cell = cell_at(arena, wrapped(column, arena.columns), wrapped(row, arena.rows))
            fetch(grains.motion, grains.cells[cell].first)
            fetch(grains.motion, grains.cells[cell].second)


@inline(exact=True)
def look_ahead(grains, arena):
    """Have what the events of coming days need brought near, in stages: each says where the next has to look."""
    queue, today = grains.queue, grains.queue.today[0]
    fetch_grain(grains, first_on(queue, today + TO_FIRST))
    i = first_on(queue, today + TO_SECOND)
    if i >= 0:
        fetch_grain(grains, np.int64(grains.prospects[i].later))
    i = first_on(queue, today + TO_ALL)
    while i >= 0:
        later = np.int64(grains.prospects[i].later)
        fetch_grain(grains, later)
        fetch_grain(grains, np.int64(grains.prospects[i].partner))
        soon = put(grains.soon, i)
        fetch_cells(grains, arena, soon)
        fetch_neighbours(grains, arena, put(grains.sooner, soon))
        i = later
