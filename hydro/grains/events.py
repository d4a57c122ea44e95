"""Event-driven dynamics: grains fly freely from event to event, and only those that take part in one are touched.

A cell list says where to look for partners (`cell_list`). A grain that leaves its cell looks only into the cells that
have come near, and neither its position nor its other prospects change. What comes next for a grain is foreseen
(`prediction`), waits in a queue (`queue`), and changes velocities when it happens (`collisions`).

Units: length L_x, velocity T_*^(1/2), mass of a grain 1. Lubachevsky, J. Comput. Phys. 94, 255 (1991); Marin, Risso
and Cordero, J. Comput. Phys. 109, 306 (1993).
"""

from __future__ import annotations

import math

import numpy as np

from hydro.grains.books import CROSSINGS, STALE
from hydro.grains.cell_list import around, enter_cell, gather, leave_cell, neighbours
from hydro.grains.collisions import collide, reflect
from hydro.grains.prediction import forget, predict
from hydro.grains.prefetch import look_ahead
from hydro.grains.queue import EVENTS, NOBODY, cancel, day_of, earliest_today, keep_pace, schedule, tomorrow
from hydro.grains.state import CANDIDATE, NOW, ORIGIN, nearest_image, position_at
from hydro.jit import inline, kernel


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
def process_event(grains, arena, wall, i, time):
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
        looking = process_event(grains, arena, wall, i, time)
        while True:
            cancel(queue, looking)
            schedule(queue, looking, predict(grains, arena, wall, looking))
            if looking == i:
                break
            looking = i
    return events


@kernel(exact=True)
def shift_times(grains, shift, period):
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
        x_i, y_i = position_at(motion, i, time)
        first_column, last_column = neighbours(motion[i].column, arena.columns, arena.periodic_x)
        first_row, last_row = neighbours(motion[i].row, arena.rows, arena.periodic_y)
        for k in range(gather(grains, arena, first_column, last_column, first_row, last_row)):
            j = grains.candidates[k, CANDIDATE]
            if j < i:
                x_j, y_j = position_at(motion, j, time)
                x = nearest_image(x_j - x_i, 1.0, arena.periodic_x)
                y = nearest_image(y_j - y_i, arena.length_y, arena.periodic_y)
                smallest = min(smallest, x * x + y * y)
    return math.sqrt(smallest) / arena.diameter - 1.0
