"""Event-driven dynamics: grains fly freely from event to event, and only those that take part in one are touched.

Each grain has a time of its own: its position is that of its last collision, `flight` tells where it is later. For
each grain the earliest collision that it foresees is kept, with the number of collisions that its partner had had
then. A partner that has collided since makes the event stale; the grain then looks again. Whichever of two grains
changed its course last has looked at the other, so nothing is missed.

A cell list says where to look. A grain that leaves its cell looks only into the cells that have come near, and neither
its position nor its other prospects change. Times of collisions depend on positions, velocities and times of the two
grains alone, in the same bits whoever computes them and when: the sequence of events does not depend on the cells.

Units: length L_x, velocity T_*^(1/2), mass of a grain 1. Lubachevsky, J. Comput. Phys. 94, 255 (1991); Marin, Risso
and Cordero, J. Comput. Phys. 109, 306 (1993).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hydro.grains.queue import (
    EVENTS,
    NOBODY,
    Queue,
    Ring,
    aligned,
    cancel,
    day_of,
    earliest_today,
    first_on,
    keep_pace,
    page_of,
    put,
    schedule,
    schedule_all,
    tomorrow,
)
from hydro.jit import fetch, inline, kernel

# What is known of a grain: a line of the cache. And of its next events: half a line.
MOTION = np.dtype({
    "names": ["x", "y", "vx", "vy", "time", "count", "following", "column", "row"],
    "formats": ["f8"] * 5 + ["i4"] * 4, "itemsize": 64,
})  # fmt: skip
PROSPECT = np.dtype({
    "names": ["event", "collision", "partner", "seen", "later", "step_x", "step_y"],
    "formats": ["f8"] * 2 + ["i4"] * 3 + ["i2"] * 2,
})  # fmt: skip
CELL = np.dtype([("first", "i4"), ("second", "i4")])  # the grains in a cell; from the second on, one tells the next
CANDIDATE, ACROSS_X, ACROSS_Y = range(3)  # columns of `candidates`
LEFT, RIGHT, BOTTOM, TOP = -2, -3, -4, -5  # partners that are no grains
WALL_ENERGY, LOSS, VIRIAL, PUSH_LEFT, PUSH_RIGHT, SUMS = range(6)
COLLISIONS, WALL_HITS, SOFT, STALE, CROSSINGS, COUNTS = range(6)
NOW, ORIGIN, CLOCK = range(3)
TO_FIRST, TO_SECOND, TO_ALL = 14, 11, 8  # days to that whose first, second grain is fetched; all are looked at
LAG = 2  # events between two looks at a grain, a power of two


class Grains(NamedTuple):
    """All that changes with an event.

    motion (N,): of each grain the position, velocity, and the time they belong to; how many collisions it has had; the
    next grain of the same cell; column and row of that. prospects (N,): the time of its next event, and of its next
    collision; its partner in that, and how many collisions the partner had had when it was foreseen; the next grain in
    the queue; by how many columns and rows the next event takes it to another cell, if it does. cells: first and second
    grain of each, NOBODY where there is none. candidates (N + 2, 3): room for the grains in a block of cells, and how
    often one goes round the box to them. soon, sooner: grains whose events are looked at ahead. clock (2,): time of the
    last event, and what to add to times to count them from the beginning of a period of the wall. random (4,): the
    state of the random numbers. sums (5,): energy given by the wall, energy lost, the virial, momentum given to the
    walls at x = 0 and x = 1. counts (5,): collisions, impacts on the driving wall, collisions that the contact time
    made elastic, stale events, changes of cell.
    """

    motion: np.ndarray
    prospects: np.ndarray
    cells: np.ndarray
    candidates: np.ndarray
    queue: Queue
    soon: Ring
    sooner: Ring
    clock: np.ndarray
    random: np.ndarray
    sums: np.ndarray
    counts: np.ndarray


class Arena(NamedTuple):
    """What no event changes: grains, box, and the borders of cells, which are a diameter or more apart."""

    diameter: float
    restitution: float
    contact_time: float
    length_y: float
    periodic_x: bool
    periodic_y: bool
    columns: int
    rows: int
    borders_x: np.ndarray  # (columns + 1,)
    borders_y: np.ndarray  # (rows + 1,)


@inline(exact=True)
def place(motion, i, time):
    """Where grain i is at a time, if nothing happens to it."""
    flight = time - motion[i].time
    return motion[i].x + motion[i].vx * flight, motion[i].y + motion[i].vy * flight


@inline(exact=True)
def meeting(motion, i, j, shift_x, shift_y, diameter):
    """When grains i and j touch, with j displaced by the shifts; infinite if never.

    The discriminant is (w d)^2 - (distance x w)^2, w the relative velocity: errors of a grazing contact are then of the
    order of round-off times the distance; closing^2 - w^2 (distance^2 - d^2) would square it.
    """
    reference = max(motion[i].time, motion[j].time)
    u, v = motion[j].vx - motion[i].vx, motion[j].vy - motion[i].vy
    x_i, y_i = place(motion, i, reference)
    x_j, y_j = place(motion, j, reference)
    x, y = x_j - x_i + shift_x, y_j - y_i + shift_y
    closing = -(x * u + y * v)
    outside = x * x + y * y - diameter * diameter
    aside = x * v - y * u
    discriminant = (u * u + v * v) * (diameter * diameter) - aside * aside
    at = reference + max(outside, 0.0) / (closing + math.sqrt(max(discriminant, 0.0)))
    return at if (closing > 0.0) & (discriminant > 0.0) else math.inf


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
def look_into(grains, arena, i, first_column, last_column, first_row, last_row):
    """Take note of the earliest collision of grain i in a block of cells, if it is earlier than what is known.

    A grain never meets itself, for it does not come closer.
    """
    motion, candidates = grains.motion, grains.candidates
    earliest, partner = grains.prospects[i].collision, np.int64(NOBODY)
    for k in range(gather(grains, arena, first_column, last_column, first_row, last_row)):
        j = np.uintp(candidates[k, CANDIDATE])
        shift_x, shift_y = candidates[k, ACROSS_X] * 1.0, candidates[k, ACROSS_Y] * arena.length_y
        at = meeting(motion, i, j, shift_x, shift_y, arena.diameter)
        partner = np.int64(j) if at < earliest else partner
        earliest = min(at, earliest)
    if partner >= 0:
        grains.prospects[i].collision = earliest
        grains.prospects[i].seen = motion[partner].count
        grains.prospects[i].partner = partner


@inline(exact=True)
def near(cell, cells, periodic):
    """First and last of the cells around one, along one direction. Beyond the last come, if periodic, the first."""
    if periodic:
        return cell - 1, cell + 1
    return max(cell - 1, 0), min(cell + 1, cells - 1)


@inline(exact=True)
def come_near(cell, cells, periodic, step):
    """Of the cells around one, along one direction, first and last of those that a step into it has brought near."""
    first, last = near(cell, cells, periodic)
    return (cell + 1 if step > 0 else first), (cell - 1 if step < 0 else last)


@inline(exact=True)
def block(grains, arena, i, column, row):
    """The cells that grain i looks into from a cell: all around, or those that the step of its event has brought near.

    First and last column, first and last row.
    """
    prospects = grains.prospects
    first_column, last_column = come_near(column, arena.columns, arena.periodic_x, prospects[i].step_x)
    first_row, last_row = come_near(row, arena.rows, arena.periodic_y, prospects[i].step_y)
    return first_column, last_column, first_row, last_row


@inline(exact=True)
def next_block(grains, arena, i):
    """The cells that grain i looks into after its next event."""
    motion, prospects = grains.motion, grains.prospects
    return block(grains, arena, i, motion[i].column + prospects[i].step_x, motion[i].row + prospects[i].step_y)


@inline(exact=True)
def look_at_walls(grains, arena, wall, i):
    """Take note of the wall that grain i meets, if that is earlier than what is known."""
    motion = grains.motion
    column, row = grains.motion[i].column, grains.motion[i].row
    start = motion[i].time
    if not arena.periodic_x:
        if column == 0 and motion[i].vx < 0.0:
            note_wall(grains, i, start + max(-motion[i].x / motion[i].vx, 0.0), LEFT)
        if column == arena.columns - 1:
            after = wall.meeting(motion[i].x, motion[i].vx, start + grains.clock[ORIGIN])
            note_wall(grains, i, start + after, RIGHT)
    if not arena.periodic_y:
        if row == 0 and motion[i].vy < 0.0:
            note_wall(grains, i, start + max(-motion[i].y / motion[i].vy, 0.0), BOTTOM)
        if row == arena.rows - 1 and motion[i].vy > 0.0:
            note_wall(grains, i, start + max((arena.length_y - motion[i].y) / motion[i].vy, 0.0), TOP)


@inline(exact=True)
def note_wall(grains, i, time, side):
    """Take note of a wall that grain i meets, if that is earlier than what is known."""
    if time < grains.prospects[i].collision:
        grains.prospects[i].collision = time
        grains.prospects[i].partner = side


@inline(exact=True)
def exit_along(x, v, cell, borders, periodic):
    """How long it takes to leave a cell along one direction, and by how many cells."""
    step = 1 if v > 0.0 else -1
    if v == 0.0 or not (periodic or 0 <= cell + step < borders.size - 1):
        return math.inf, step
    return max((borders[cell + (v > 0.0)] - x) / v, 0.0), step


@inline(exact=True)
def exit_of(grains, arena, i):
    """How long it takes grain i to leave its cell, counted from its own time, and by how many columns and rows."""
    motion = grains.motion
    in_x, step_x = exit_along(motion[i].x, motion[i].vx, motion[i].column, arena.borders_x, arena.periodic_x)
    in_y, step_y = exit_along(motion[i].y, motion[i].vy, motion[i].row, arena.borders_y, arena.periodic_y)
    if in_x < in_y:
        return in_x, step_x, 0
    return in_y, 0, step_y


@inline(exact=True)
def look_out(grains, arena, wall, i):
    """The time of the next event of grain i: what is known already, or what comes from cells around, walls or borders.

    After a step into its cell it looks only into those that have come near.
    """
    motion, prospects = grains.motion, grains.prospects
    first_column, last_column, first_row, last_row = block(grains, arena, i, motion[i].column, motion[i].row)
    look_into(grains, arena, i, first_column, last_column, first_row, last_row)
    look_at_walls(grains, arena, wall, i)
    after, step_x, step_y = exit_of(grains, arena, i)
    leaving, collision = motion[i].time + after, prospects[i].collision
    leaves = leaving < collision
    prospects[i].step_x, prospects[i].step_y = step_x * leaves, step_y * leaves
    return min(collision, leaving)


@inline(exact=True)
def forget(grains, i):
    """Nothing is known of what comes for grain i."""
    prospects = grains.prospects
    prospects[i].collision, prospects[i].partner = math.inf, NOBODY
    prospects[i].step_x, prospects[i].step_y = 0, 0


@inline(exact=True)
def change_cell(grains, arena, i):
    """Grain i enters the next cell.

    One that leaves a periodic box and enters it anew has other digits, so what was foreseen of it is stale.
    """
    motion, prospects = grains.motion, grains.prospects
    column, row = motion[i].column + prospects[i].step_x, motion[i].row + prospects[i].step_y
    across_x, across_y = around(column, arena.columns), around(row, arena.rows)
    leave_cell(grains, arena, i)
    enter_cell(grains, arena, i, column - across_x * arena.columns, row - across_y * arena.rows)
    if across_x != 0 or across_y != 0:
        motion[i].x -= across_x * 1.0
        motion[i].y -= across_y * arena.length_y
        motion[i].count += 1
        forget(grains, i)


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


@inline(exact=True)
def fly(motion, i, time):
    """Bring grain i to a time."""
    motion[i].x, motion[i].y = place(motion, i, time)
    motion[i].time = time


@inline(exact=True)
def nearest_image(distance, length, periodic):
    """The shortest of the distances between periodic images."""
    return distance - length * np.rint(distance / length) if periodic else distance


@inline(exact=True)
def collide(grains, arena, i, j, time):
    """Two grains touch: the normal part of their relative velocity is turned round and shrinks by the restitution.

    Within the contact time after a collision of either, nothing is lost (Luding and McNamara, Granular Matter 1, 113,
    1998).
    """
    motion = grains.motion
    soft = time - max(motion[i].time, motion[j].time) < arena.contact_time
    restitution = 1.0 if soft else arena.restitution
    fly(motion, i, time)
    fly(motion, j, time)
    x = nearest_image(motion[j].x - motion[i].x, 1.0, arena.periodic_x)
    y = nearest_image(motion[j].y - motion[i].y, arena.length_y, arena.periodic_y)
    distance = math.sqrt(x * x + y * y)
    x, y = x / distance, y / distance
    closing = -((motion[j].vx - motion[i].vx) * x + (motion[j].vy - motion[i].vy) * y)
    impulse = 0.5 * (1.0 + restitution) * closing
    motion[i].vx -= impulse * x
    motion[i].vy -= impulse * y
    motion[j].vx += impulse * x
    motion[j].vy += impulse * y
    motion[i].count += 1
    motion[j].count += 1
    grains.sums[LOSS] += 0.25 * (1.0 - restitution * restitution) * closing * closing
    grains.sums[VIRIAL] += impulse * distance
    grains.counts[COLLISIONS] += 1
    grains.counts[SOFT] += soft


@inline(exact=True)
def reflect(grains, wall, i, side, time):
    """Grain i meets a wall."""
    motion, sums = grains.motion, grains.sums
    fly(motion, i, time)
    if side == RIGHT:
        before, across = motion[i].vx, motion[i].vy
        motion[i].vx, motion[i].vy = wall.rebound(before, across, time + grains.clock[ORIGIN], grains.random)
        sums[PUSH_RIGHT] += before - motion[i].vx
        sums[WALL_ENERGY] += 0.5 * (motion[i].vx ** 2 - before**2 + (motion[i].vy ** 2 - across**2))
        grains.counts[WALL_HITS] += 1
    elif side == LEFT:
        sums[PUSH_LEFT] -= 2.0 * motion[i].vx
        motion[i].vx = -motion[i].vx
    else:
        motion[i].vy = -motion[i].vy
    motion[i].count += 1


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
def near_both(cell, other, cells, periodic):
    """First and last of the cells around two cells side by side, along one direction; of two far apart, around one."""
    (first, _), (_, last) = near(min(cell, other), cells, periodic), near(max(cell, other), cells, periodic)
    return first, min(last, first + 3)


@inline(exact=True)
def around_both(grains, arena, i):
    """The cells around grain i, and around its partner or the cell that its next event takes it to; as from `block`."""
    motion, prospects = grains.motion, grains.prospects
    column, row = motion[i].column, motion[i].row
    other_column, other_row = column + prospects[i].step_x, row + prospects[i].step_y
    if collides(grains, i):
        partner = np.int64(prospects[i].partner)
        other_column, other_row = motion[partner].column, motion[partner].row
    first_column, last_column = near_both(column, other_column, arena.columns, arena.periodic_x)
    first_row, last_row = near_both(row, other_row, arena.rows, arena.periodic_y)
    return first_column, last_column, first_row, last_row


@inline(exact=True)
def fetch_cells(grains, arena, i):
    """Have the cells brought near that the next event of grain i is about, and the page of that of its partner.

    Beyond the border of a periodic box they are not the right ones, which does no harm.
    """
    first_column, last_column, first_row, last_row = around_both(grains, arena, i)
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
        first_column, last_column, first_row, last_row = around_both(grains, arena, i)
    else:
        first_column, last_column, first_row, last_row = next_block(grains, arena, i)
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


@inline(exact=True)
def happen(grains, arena, wall, i, time):
    """The next event of grain i; returns the grain with which it has collided, otherwise i."""
    prospects = grains.prospects
    if time < prospects[i].collision:
        grains.counts[CROSSINGS] += 1
        change_cell(grains, arena, i)
        return i
    partner, other = np.int64(prospects[i].partner), i
    if partner < 0:
        reflect(grains, wall, i, partner, time)
    elif prospects[i].seen == grains.motion[partner].count:
        collide(grains, arena, i, partner, time)
        forget(grains, partner)
        other = partner
    else:
        grains.counts[STALE] += 1
    forget(grains, i)
    return other


@kernel(exact=True)
def run(grains, arena, wall, until, budget):
    """All events up to a time, or as many as the budget allows; returns how many there were."""
    queue = grains.queue
    events = 0
    while events < budget:
        keep_pace(queue, grains.clock[NOW])
        i = earliest_today(queue)
        if i == NOBODY:
            if queue.today[0] >= day_of(queue, until):
                break
            tomorrow(queue)
            look_ahead(grains, arena)
            continue
        time = queue.entries[i].event
        if time > until:
            break
        events += 1
        queue.since[EVENTS] += 1
        grains.clock[NOW] = time
        looking = happen(grains, arena, wall, i, time)
        while True:
            cancel(queue, looking)
            schedule(queue, looking, look_out(grains, arena, wall, looking))
            if looking == i:
                break
            looking = i
    return events


@kernel(exact=True)
def fill_cells(grains, arena, cells):
    """Put every grain into its cell, given by column and row, shape (N, 2)."""
    for cell in range(grains.cells.size):
        grains.cells[cell].first, grains.cells[cell].second = NOBODY, NOBODY
    for i in range(len(cells)):
        enter_cell(grains, arena, i, cells[i, 0], cells[i, 1])


@kernel(exact=True)
def foresee_all(grains, arena, wall):
    """The next event of every grain."""
    for i in range(grains.motion.shape[0]):
        forget(grains, i)
        grains.prospects[i].event = look_out(grains, arena, wall, i)
    schedule_all(grains.queue, grains.clock[NOW])


@kernel(exact=True)
def count_time_from(grains, shift, period):
    """Take `shift` as the new zero of all times. What was foreseen is void."""
    for i in range(grains.motion.shape[0]):
        grains.motion[i].time -= shift
    grains.clock[NOW] -= shift
    grains.clock[ORIGIN] = (grains.clock[ORIGIN] + shift) % period


@kernel(exact=True)
def smallest_gap(grains, arena, time):
    """The smallest distance between centres of grains at a time, over the diameter, less one; among neighbours."""
    motion = grains.motion
    smallest = math.inf
    for i in range(motion.shape[0]):
        x_i, y_i = place(motion, i, time)
        first_column, last_column = near(motion[i].column, arena.columns, arena.periodic_x)
        first_row, last_row = near(motion[i].row, arena.rows, arena.periodic_y)
        for k in range(gather(grains, arena, first_column, last_column, first_row, last_row)):
            j = grains.candidates[k, CANDIDATE]
            if j < i:
                x_j, y_j = place(motion, j, time)
                x = nearest_image(x_j - x_i, 1.0, arena.periodic_x)
                y = nearest_image(y_j - y_i, arena.length_y, arena.periodic_y)
                smallest = min(smallest, x * x + y * y)
    return math.sqrt(smallest) / arena.diameter - 1.0
