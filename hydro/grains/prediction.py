"""Prediction of the next event of a grain: a collision with another, a wall, or the border of its cell.

For each grain the earliest collision that it foresees is kept, with the number of collisions that its partner had had
then. A partner that has collided since makes the event stale; the grain then looks again. Whichever of two grains
changed its course last has looked at the other, so nothing is missed.

Times of collisions depend on positions, velocities and times of the two grains alone, in the same bits whoever computes
them and when: the sequence of events does not depend on the cells.
"""

from __future__ import annotations

import math

import numpy as np

from hydro.grains.cell_list import gather, new_neighbours
from hydro.grains.queue import NOBODY, schedule_all
from hydro.grains.state import ACROSS_X, ACROSS_Y, CANDIDATE, NOW, ORIGIN, position_at
from hydro.jit import inline, kernel

LEFT, RIGHT, BOTTOM, TOP = -2, -3, -4, -5  # partners that are no grains


@inline(exact=True)
def collision_time(motion, i, j, shift_x, shift_y, diameter):
    """When grains i and j touch, with j displaced by the shifts; infinite if never.

    The discriminant is (w d)^2 - (distance x w)^2, w the relative velocity: errors of a grazing contact are then of the
    order of round-off times the distance; closing^2 - w^2 (distance^2 - d^2) would square it.
    """
    reference = max(motion[i].time, motion[j].time)
    u, v = motion[j].vx - motion[i].vx, motion[j].vy - motion[i].vy
    x_i, y_i = position_at(motion, i, reference)
    x_j, y_j = position_at(motion, j, reference)
    x, y = x_j - x_i + shift_x, y_j - y_i + shift_y
    closing = -(x * u + y * v)
    outside = x * x + y * y - diameter * diameter
    aside = x * v - y * u
    discriminant = (u * u + v * v) * (diameter * diameter) - aside * aside
    at = reference + max(outside, 0.0) / (closing + math.sqrt(max(discriminant, 0.0)))
    return at if (closing > 0.0) & (discriminant > 0.0) else math.inf


@inline(exact=True)
def cells_to_search(grains, arena, i, column, row):
    """The cells that grain i looks into from a cell: all around, or those that the step of its event has brought near.

    First and last column, first and last row.
    """
    prospects = grains.prospects
    first_column, last_column = new_neighbours(column, arena.columns, arena.periodic_x, prospects[i].step_x)
    first_row, last_row = new_neighbours(row, arena.rows, arena.periodic_y, prospects[i].step_y)
    return first_column, last_column, first_row, last_row


@inline(exact=True)
def predict_collision(grains, arena, i, first_column, last_column, first_row, last_row):
    """Take note of the earliest collision of grain i in a block of cells, if it is earlier than what is known.

    A grain never meets itself, for it does not come closer.
    """
    motion, candidates = grains.motion, grains.candidates
    earliest, partner = grains.prospects[i].collision, np.int64(NOBODY)
    for k in range(gather(grains, arena, first_column, last_column, first_row, last_row)):
        j = np.uintp(candidates[k, CANDIDATE])
        shift_x, shift_y = candidates[k, ACROSS_X] * 1.0, candidates[k, ACROSS_Y] * arena.length_y
        at = collision_time(motion, i, j, shift_x, shift_y, arena.diameter)
        partner = np.int64(j) if at < earliest else partner
        earliest = min(at, earliest)
    if partner >= 0:
        grains.prospects[i].collision = earliest
        grains.prospects[i].seen = motion[partner].count
        grains.prospects[i].partner = partner


@inline(exact=True)
def predict_wall_hit(grains, arena, wall, i):
    """Take note of the wall that grain i meets, if that is earlier than what is known."""
    motion = grains.motion
    column, row = grains.motion[i].column, grains.motion[i].row
    start = motion[i].time
    if not arena.periodic_x:
        if column == 0 and motion[i].vx < 0.0:
            note_wall_hit(grains, i, start + max(-motion[i].x / motion[i].vx, 0.0), LEFT)
        if column == arena.columns - 1:
            after = wall.meeting(motion[i].x, motion[i].vx, start + grains.clock[ORIGIN])
            note_wall_hit(grains, i, start + after, RIGHT)
    if not arena.periodic_y:
        if row == 0 and motion[i].vy < 0.0:
            note_wall_hit(grains, i, start + max(-motion[i].y / motion[i].vy, 0.0), BOTTOM)
        if row == arena.rows - 1 and motion[i].vy > 0.0:
            note_wall_hit(grains, i, start + max((arena.length_y - motion[i].y) / motion[i].vy, 0.0), TOP)


@inline(exact=True)
def note_wall_hit(grains, i, time, side):
    """Take note of a wall that grain i meets, if that is earlier than what is known."""
    if time < grains.prospects[i].collision:
        grains.prospects[i].collision = time
        grains.prospects[i].partner = side


@inline(exact=True)
def crossing_along(x, v, cell, borders, periodic):
    """How long it takes to leave a cell along one direction, and by how many cells."""
    step = 1 if v > 0.0 else -1
    if v == 0.0 or not (periodic or 0 <= cell + step < borders.size - 1):
        return math.inf, step
    return max((borders[cell + (v > 0.0)] - x) / v, 0.0), step


@inline(exact=True)
def cell_crossing(grains, arena, i):
    """How long it takes grain i to leave its cell, counted from its own time, and by how many columns and rows."""
    motion = grains.motion
    in_x, step_x = crossing_along(motion[i].x, motion[i].vx, motion[i].column, arena.borders_x, arena.periodic_x)
    in_y, step_y = crossing_along(motion[i].y, motion[i].vy, motion[i].row, arena.borders_y, arena.periodic_y)
    if in_x < in_y:
        return in_x, step_x, 0
    return in_y, 0, step_y


@inline(exact=True)
def predict(grains, arena, wall, i):
    """The time of the next event of grain i: what is known already, or what comes from cells around, walls or borders.

    After a step into its cell it looks only into those that have come near.
    """
    motion, prospects = grains.motion, grains.prospects
    first_column, last_column, first_row, last_row = cells_to_search(grains, arena, i, motion[i].column, motion[i].row)
    predict_collision(grains, arena, i, first_column, last_column, first_row, last_row)
    predict_wall_hit(grains, arena, wall, i)
    after, step_x, step_y = cell_crossing(grains, arena, i)
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


@kernel(exact=True)
def predict_all(grains, arena, wall):
    """The next event of every grain."""
    for i in range(grains.motion.shape[0]):
        forget(grains, i)
        grains.prospects[i].event = predict(grains, arena, wall, i)
    schedule_all(grains.queue, grains.clock[NOW])
