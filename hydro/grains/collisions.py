"""Collisions: what happens to the velocities of two grains, or of a grain and a wall, and what the books say of it."""

from __future__ import annotations

import math

from hydro.grains.books import (
    COLLISIONS,
    LOSS,
    PUSH_LEFT,
    PUSH_RIGHT,
    SOFT,
    VIRIAL,
    WALL_ENERGY,
    WALL_HITS,
)
from hydro.grains.prediction import LEFT, RIGHT
from hydro.grains.state import ORIGIN, move_to, nearest_image
from hydro.jit import inline


@inline(exact=True)
def collide(grains, arena, i, j, time):
    """Two grains touch: the normal part of their relative velocity is turned round and shrinks by the restitution.

    Within the contact time after a collision of either, nothing is lost (Luding and McNamara, Granular Matter 1, 113,
    1998).
    """
    motion = grains.motion
    soft = time - max(motion[i].time, motion[j].time) < arena.contact_time
    restitution = 1.0 if soft else arena.restitution
    move_to(motion, i, time)
    move_to(motion, j, time)
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
    move_to(motion, i, time)
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
