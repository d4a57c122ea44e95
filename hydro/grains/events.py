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

from hydro.grains.queue import ROOT, Queue, children, reschedule
from hydro.jit import fetch, inline, kernel

X, Y, VX, VY, TIME, COLLISION, COUNT, SEEN, MOTION = range(9)  # columns of `motion`: its rows are lines of the cache
COLUMN, ROW = range(2)  # columns of `cells`
CANDIDATE, ACROSS_X, ACROSS_Y = range(3)  # columns of `candidates`
NOBODY, LEFT, RIGHT, BOTTOM, TOP = -1, -2, -3, -4, -5  # partners that are no grains
WALL_ENERGY, LOSS, VIRIAL, PUSH_LEFT, PUSH_RIGHT, SUMS = range(6)
COLLISIONS, WALL_HITS, SOFT, STALE, CROSSINGS, COUNTS = range(6)
NOW, ORIGIN, CLOCK = range(3)


class Grains(NamedTuple):
    """All that changes with an event.

    motion (N, 8): position, velocity, the time they belong to; the time of the next collision; how many collisions
    the grain has had, and its partner in the next one when that was foreseen. partners (N,): that partner. cells
    (N, 2): column and row of the cell. heads (columns, rows): first grain of each cell. following (N,): next grain of
    the same cell. candidates (N + 2, 3): room for the grains in a block of cells, and how often one goes round the box
    to them. clock (2,): time of the last event, and what to add to times to count them from the beginning of a period
    of the wall. random (4,): the state of the random numbers. sums (5,): energy given by the wall, energy lost, the
    virial, momentum given to the walls at x = 0 and x = 1. counts (5,): collisions, impacts on the driving wall,
    collisions that the contact time made elastic, stale events, changes of cell.
    """

    motion: np.ndarray
    partners: np.ndarray
    cells: np.ndarray
    heads: np.ndarray
    following: np.ndarray
    candidates: np.ndarray
    queue: Queue
    clock: np.ndarray
    random: np.ndarray
    sums: np.ndarray
    counts: np.ndarray


class Arena(NamedTuple):
    """What does not change: grains, box, cells."""

    diameter: float
    restitution: float
    contact_time: float
    length_y: float
    periodic_x: bool
    periodic_y: bool
    columns: int
    rows: int
    width: float  # of a cell
    height: float


@inline(exact=True)
def place(motion, i, time):
    """Where grain i is at a time, if nothing happens to it."""
    flight = time - motion[i, TIME]
    return motion[i, X] + motion[i, VX] * flight, motion[i, Y] + motion[i, VY] * flight


@inline(exact=True)
def meeting(motion, i, j, shift_x, shift_y, diameter):
    """When grains i and j touch, with j displaced by the shifts; infinite if never."""
    reference = max(motion[i, TIME], motion[j, TIME])
    u, v = motion[j, VX] - motion[i, VX], motion[j, VY] - motion[i, VY]
    x_i, y_i = place(motion, i, reference)
    x_j, y_j = place(motion, j, reference)
    x, y = x_j - x_i + shift_x, y_j - y_i + shift_y
    closing = -(x * u + y * v)
    outside = x * x + y * y - diameter * diameter
    discriminant = closing * closing - (u * u + v * v) * outside
    at = reference + max(outside, 0.0) / (closing + math.sqrt(max(discriminant, 0.0)))
    return at if (closing > 0.0) & (discriminant > 0.0) else math.inf


@inline(exact=True)
def around(cell, cells):
    """How often one goes round a periodic box to a cell beyond its border: -1, 0 or 1."""
    return (cell >= cells) - (cell < 0)


@inline(exact=True)
def gather(grains, arena, first_column, last_column, first_row, last_row):
    """List the grains in a block of cells as candidates; returns how many there are.

    Without branches: what is written behind the last candidate is written over.
    """
    heads, following, candidates = grains.heads, grains.following, grains.candidates
    found = 0
    for column in range(first_column, last_column + 1):
        across_x = around(column, arena.columns)
        in_column = heads[column - across_x * arena.columns]
        for row in range(first_row, last_row + 1):
            across_y = around(row, arena.rows)
            first = in_column[row - across_y * arena.rows]
            candidates[found, CANDIDATE] = first
            candidates[found, ACROSS_X] = across_x
            candidates[found, ACROSS_Y] = across_y
            found += first >= 0
    k = 0
    while k < found:
        after = following[candidates[k, CANDIDATE]]
        candidates[found, CANDIDATE] = after
        candidates[found, ACROSS_X] = candidates[k, ACROSS_X]
        candidates[found, ACROSS_Y] = candidates[k, ACROSS_Y]
        found += after >= 0
        k += 1
    return found


@inline(exact=True)
def look_into(grains, arena, i, first_column, last_column, first_row, last_row):
    """Take note of the earliest collision of grain i in a block of cells, if it is earlier than what is known.

    A grain never meets itself, for it does not come closer.
    """
    motion, candidates = grains.motion, grains.candidates
    earliest, partner = motion[i, COLLISION], np.int64(NOBODY)
    for k in range(gather(grains, arena, first_column, last_column, first_row, last_row)):
        j = np.int64(candidates[k, CANDIDATE])
        shift_x, shift_y = candidates[k, ACROSS_X] * 1.0, candidates[k, ACROSS_Y] * arena.length_y
        at = meeting(motion, i, j, shift_x, shift_y, arena.diameter)
        partner = j if at < earliest else partner
        earliest = min(at, earliest)
    if partner >= 0:
        motion[i, COLLISION] = earliest
        motion[i, SEEN] = motion[partner, COUNT]
        grains.partners[i] = partner


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
    if step > 0:
        return cell + 1, last
    if step < 0:
        return first, cell - 1
    return first, last


@inline(exact=True)
def look_at_walls(grains, arena, wall, i):
    """Take note of the wall that grain i meets, if that is earlier than what is known."""
    motion = grains.motion
    column, row = grains.cells[i, COLUMN], grains.cells[i, ROW]
    start = motion[i, TIME]
    if not arena.periodic_x:
        if column == 0 and motion[i, VX] < 0.0:
            note_wall(grains, i, start + max(-motion[i, X] / motion[i, VX], 0.0), LEFT)
        if column == arena.columns - 1:
            after = wall.meeting(motion[i, X], motion[i, VX], start + grains.clock[ORIGIN])
            note_wall(grains, i, start + after, RIGHT)
    if not arena.periodic_y:
        if row == 0 and motion[i, VY] < 0.0:
            note_wall(grains, i, start + max(-motion[i, Y] / motion[i, VY], 0.0), BOTTOM)
        if row == arena.rows - 1 and motion[i, VY] > 0.0:
            note_wall(grains, i, start + max((arena.length_y - motion[i, Y]) / motion[i, VY], 0.0), TOP)


@inline(exact=True)
def note_wall(grains, i, time, side):
    """Take note of a wall that grain i meets, if that is earlier than what is known."""
    if time < grains.motion[i, COLLISION]:
        grains.motion[i, COLLISION] = time
        grains.partners[i] = side


@inline(exact=True)
def exit_along(x, v, cell, cells, size, periodic):
    """How long it takes to leave a cell along one direction, and by how many cells."""
    step = 1 if v > 0.0 else -1
    if v == 0.0 or not (periodic or 0 <= cell + step < cells):
        return math.inf, step
    border = (cell + 1) * size if v > 0.0 else cell * size
    return max((border - x) / v, 0.0), step


@inline(exact=True)
def exit_of(grains, arena, i):
    """How long it takes grain i to leave its cell, counted from its own time, and by how many columns and rows."""
    motion, cells = grains.motion, grains.cells
    in_x, step_x = exit_along(
        motion[i, X], motion[i, VX], cells[i, COLUMN], arena.columns, arena.width, arena.periodic_x
    )
    in_y, step_y = exit_along(motion[i, Y], motion[i, VY], cells[i, ROW], arena.rows, arena.height, arena.periodic_y)
    if in_x < in_y:
        return in_x, step_x, 0
    return in_y, 0, step_y


@inline(exact=True)
def look_out(grains, arena, wall, i, step_x, step_y):
    """The next event of grain i: what is known already, or what comes from cells around, from walls or borders.

    After a step into its cell, by so many columns and rows, it looks only into those that have come near.
    """
    motion, cells = grains.motion, grains.cells
    first_column, last_column = come_near(cells[i, COLUMN], arena.columns, arena.periodic_x, step_x)
    first_row, last_row = come_near(cells[i, ROW], arena.rows, arena.periodic_y, step_y)
    look_into(grains, arena, i, first_column, last_column, first_row, last_row)
    look_at_walls(grains, arena, wall, i)
    leaving = motion[i, TIME] + exit_of(grains, arena, i)[0]
    reschedule(grains.queue, i, min(motion[i, COLLISION], leaving))


@inline(exact=True)
def forget(grains, i):
    """Nothing is known of what comes for grain i."""
    grains.motion[i, COLLISION] = math.inf
    grains.partners[i] = NOBODY


@inline(exact=True)
def change_cell(grains, arena, i):
    """Grain i enters the next cell; returns by how many columns and rows it steps, as one that looks out wants to know.

    One that leaves a periodic box and enters it anew has other digits, so what was foreseen of it is stale.
    """
    motion, cells = grains.motion, grains.cells
    _, step_x, step_y = exit_of(grains, arena, i)
    column, row = cells[i, COLUMN] + step_x, cells[i, ROW] + step_y
    across_x, across_y = around(column, arena.columns), around(row, arena.rows)
    leave_cell(grains, i)
    enter_cell(grains, i, column - across_x * arena.columns, row - across_y * arena.rows)
    if across_x == 0 and across_y == 0:
        return step_x, step_y
    motion[i, X] -= across_x * 1.0
    motion[i, Y] -= across_y * arena.length_y
    motion[i, COUNT] += 1.0
    forget(grains, i)
    return 0, 0


@inline(exact=True)
def leave_cell(grains, i):
    """Take grain i out of the list of its cell."""
    heads, following = grains.heads, grains.following
    column, row = grains.cells[i, COLUMN], grains.cells[i, ROW]
    before = heads[column, row]
    if before == i:
        heads[column, row] = following[i]
        return
    while following[before] != i:
        before = following[before]
    following[before] = following[i]


@inline(exact=True)
def enter_cell(grains, i, column, row):
    """Put grain i at the head of the list of a cell."""
    grains.cells[i, COLUMN], grains.cells[i, ROW] = column, row
    grains.following[i] = grains.heads[column, row]
    grains.heads[column, row] = i


@inline(exact=True)
def fly(motion, i, time):
    """Bring grain i to a time."""
    motion[i, X], motion[i, Y] = place(motion, i, time)
    motion[i, TIME] = time


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
    soft = time - max(motion[i, TIME], motion[j, TIME]) < arena.contact_time
    restitution = 1.0 if soft else arena.restitution
    fly(motion, i, time)
    fly(motion, j, time)
    x = nearest_image(motion[j, X] - motion[i, X], 1.0, arena.periodic_x)
    y = nearest_image(motion[j, Y] - motion[i, Y], arena.length_y, arena.periodic_y)
    distance = math.sqrt(x * x + y * y)
    x, y = x / distance, y / distance
    closing = -((motion[j, VX] - motion[i, VX]) * x + (motion[j, VY] - motion[i, VY]) * y)
    impulse = 0.5 * (1.0 + restitution) * closing
    motion[i, VX] -= impulse * x
    motion[i, VY] -= impulse * y
    motion[j, VX] += impulse * x
    motion[j, VY] += impulse * y
    motion[i, COUNT] += 1.0
    motion[j, COUNT] += 1.0
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
        before, across = motion[i, VX], motion[i, VY]
        motion[i, VX], motion[i, VY] = wall.rebound(before, across, time + grains.clock[ORIGIN], grains.random)
        sums[PUSH_RIGHT] += before - motion[i, VX]
        sums[WALL_ENERGY] += 0.5 * (motion[i, VX] ** 2 - before**2 + (motion[i, VY] ** 2 - across**2))
        grains.counts[WALL_HITS] += 1
    elif side == LEFT:
        sums[PUSH_LEFT] -= 2.0 * motion[i, VX]
        motion[i, VX] = -motion[i, VX]
    else:
        motion[i, VY] = -motion[i, VY]
    motion[i, COUNT] += 1.0


@inline(exact=True)
def fetch_next(grains):
    """Have what is known of the grains brought near that stand right behind the first: one of them is likely next."""
    queue, first = grains.queue, children(ROOT)
    for place in range(first, first + 4):
        i = queue.grains[place]
        fetch(grains.motion, i)
        fetch(grains.cells, i)
        fetch(grains.partners, i)
        fetch(queue.places, i)


@kernel(exact=True)
def run(grains, arena, wall, until, budget):
    """All events up to a time, or as many as the budget allows; returns how many there were."""
    motion, queue = grains.motion, grains.queue
    events = 0
    while queue.times[ROOT] <= until and events < budget:
        events += 1
        i, time = np.int64(queue.grains[ROOT]), queue.times[ROOT]
        grains.clock[NOW] = time
        fetch_next(grains)
        step_x, step_y, looking = 0, 0, i
        if time < motion[i, COLLISION]:
            grains.counts[CROSSINGS] += 1
            step_x, step_y = change_cell(grains, arena, i)
        else:
            partner = np.int64(grains.partners[i])
            if partner < 0:
                reflect(grains, wall, i, partner, time)
            elif motion[i, SEEN] == motion[partner, COUNT]:
                collide(grains, arena, i, partner, time)
                forget(grains, partner)
                looking = partner
            else:
                grains.counts[STALE] += 1
            forget(grains, i)
        while True:
            look_out(grains, arena, wall, looking, step_x, step_y)
            if looking == i:
                break
            looking = i
    return events


@kernel(exact=True)
def fill_cells(grains, cells):
    """Put every grain into its cell, given by column and row, shape (N, 2)."""
    grains.heads[:] = NOBODY
    for i in range(len(cells)):
        enter_cell(grains, i, cells[i, COLUMN], cells[i, ROW])


@kernel(exact=True)
def foresee_all(grains, arena, wall):
    """The next event of every grain."""
    for i in range(grains.motion.shape[0]):
        forget(grains, i)
        look_out(grains, arena, wall, i, 0, 0)


@kernel(exact=True)
def count_time_from(grains, shift, period):
    """Take `shift` as the new zero of all times. What was foreseen is void."""
    for i in range(grains.motion.shape[0]):
        grains.motion[i, TIME] -= shift
    grains.clock[NOW] -= shift
    grains.clock[ORIGIN] = (grains.clock[ORIGIN] + shift) % period


@kernel(exact=True)
def smallest_gap(grains, arena, time):
    """The smallest distance between centres of grains at a time, over the diameter, less one; among neighbours."""
    motion, cells = grains.motion, grains.cells
    smallest = math.inf
    for i in range(motion.shape[0]):
        x_i, y_i = place(motion, i, time)
        first_column, last_column = near(cells[i, COLUMN], arena.columns, arena.periodic_x)
        first_row, last_row = near(cells[i, ROW], arena.rows, arena.periodic_y)
        for k in range(gather(grains, arena, first_column, last_column, first_row, last_row)):
            j = grains.candidates[k, CANDIDATE]
            if j < i:
                x_j, y_j = place(motion, j, time)
                x = nearest_image(x_j - x_i, 1.0, arena.periodic_x)
                y = nearest_image(y_j - y_i, arena.length_y, arena.periodic_y)
                smallest = min(smallest, x * x + y * y)
    return math.sqrt(smallest) / arena.diameter - 1.0
