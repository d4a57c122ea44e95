"""Branches of steady states: pseudo-arclength continuation in one parameter.

A family holds problems that differ in one parameter. A branch is a curve in the space of (unknowns, parameter); it is
followed by its arclength, so that it may turn back at a fold (Keller 1977; see Doedel, Keller and Kernevez, Int. J.
Bifurcation Chaos 1, 493, 1991). Lengths are measured in the root mean square, weighted by the problem, of the change of
the unknowns, and in the change of the logarithm of the parameter. What the unknowns mean, and which parameters there
are, is the problem's own affair.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from hydro.errors import RunFailed
from hydro.steady.linear import Bordered, Singular
from hydro.steady.newton import line_search, norm, solve
from hydro.steady.problem import NotConverged, Problem

PARAMETER_WEIGHT = 10.0  # of a change of log(parameter) against one of the unknowns
DIFFERENCE = 1e-5  # of log(parameter), for derivatives in it
ITERATIONS = 12
CLOSE = 1e-8
EASY = 4  # iterations after which the next step may be longer
LONGER, SHORTER = 1.4, 0.4
SHORTEST = 1e-3  # step, as a share of the longest
FIRST = 0.25  # step off the state that the branch leaves, likewise
RETURNED = 1e-3  # amplitude below which a branch is back there
FOLD_ITERATIONS = 4

P = TypeVar("P", bound=Problem)


class Family(Generic[P]):
    """Steady problems that differ in a parameter; vectors are the unknowns u, (N + k,), and log(parameter)."""

    def __init__(self, base: P, parameter: str):
        self.base, self.parameter = base, parameter

    def at(self, log_value: float) -> P:
        """The problem for a value of the parameter."""
        return self.base.with_parameter(self.parameter, math.exp(log_value))

    def residual(self, vector: np.ndarray) -> np.ndarray:
        """That of the problem, (N + k,)."""
        return self.at(vector[-1]).residual(vector[:-1])

    def in_parameter(self, vector: np.ndarray) -> np.ndarray:
        """Derivative of the residual in log(parameter), (N + k,)."""
        up, down = (self.at(vector[-1] + shift).residual(vector[:-1]) for shift in (DIFFERENCE, -DIFFERENCE))
        return (up - down) / (2.0 * DIFFERENCE)

    def dual(self, vector: np.ndarray) -> np.ndarray:
        """The row whose product with a change gives the inner product with `vector`."""
        return np.append(self.base.weights * vector[:-1], PARAMETER_WEIGHT**2 * vector[-1])

    def length(self, vector: np.ndarray) -> float:
        """The length of a change."""
        return float(np.sqrt(self.dual(vector) @ vector))

    def bordered(self, vector: np.ndarray, row: np.ndarray) -> Bordered:
        """The derivative of the residual, with `row` for the condition that fixes the place along the branch."""
        matrix, columns, rows, corner = self.at(vector[-1]).slopes(vector[:-1])
        count, last = matrix.shape[0], self.in_parameter(vector)[:, None]
        corner = np.block([[corner, last[count:]], [row[None, count:]]])
        return Bordered(matrix, np.hstack([columns, last[:count]]), np.vstack([rows, row[:count]]), corner)

    def tangent(self, vector: np.ndarray, like: np.ndarray) -> np.ndarray:
        """The unit tangent of the branch in the direction of `like`."""
        row = self.dual(like)
        found = self.bordered(vector, row).solve(np.append(np.zeros(vector.size - 1), 1.0))
        return found / self.length(found)

    def corrected(self, guess: np.ndarray, direction: np.ndarray) -> tuple[np.ndarray, int]:
        """The point of the branch in the plane through `guess` across `direction`, and the iterations it took.

        NotConverged if there is none near.
        """
        row, vector = self.dual(direction), guess
        scale = np.append(self.at(guess[-1]).scale(guess[:-1]), 1.0)

        def whole(at: np.ndarray) -> np.ndarray:
            return np.append(self.residual(at), row @ (at - guess))

        residual = whole(vector)
        for iteration in range(1, ITERATIONS + 1):
            try:
                step = self.bordered(vector, row).solve(-residual)
            except Singular:
                break
            share = line_search(lambda at: norm(whole(at), scale), vector, step, norm(residual, scale))
            if not np.isfinite(step).all() or share < 0.1:
                break
            vector = vector + share * step
            residual = whole(vector)
            if np.max(np.abs(step)) < CLOSE:
                return vector, iteration
        raise NotConverged("the corrector of the continuation does not converge")

    def at_value(self, value: float, near: np.ndarray) -> np.ndarray:
        """The point of the branch at a value of the parameter, close to `near`."""
        return np.append(solve(self.at(math.log(value)), near[:-1]).unknowns, math.log(value))

    def amplitude(self, vector: np.ndarray) -> float:
        """How far the state is from where the branch left."""
        return self.base.amplitude(vector[:-1])


@dataclass(frozen=True, eq=False)
class Point:
    """A point of a branch: its vector and unit tangent; where the branch begins, the way it leaves."""

    vector: np.ndarray
    tangent: np.ndarray

    @property
    def value(self) -> float:
        """The parameter."""
        return math.exp(self.vector[-1])


def follow(family: Family, start: Point, limits: tuple[float, float], longest: float) -> Iterator[Point]:
    """The points of the branch that begins at `start`, until it leaves the limits or returns.

    longest: the longest step. RunFailed where the branch cannot be followed, with how far it got.
    """
    here, direction, step = start.vector, start.tangent, FIRST * longest
    while True:
        try:
            vector, iterations = family.corrected(here + step * direction, direction)
            tangent = family.tangent(vector, direction)
        except (NotConverged, Singular):
            step *= SHORTER
            if step < SHORTEST * longest:
                raise RunFailed(f"the branch is lost at {family.parameter} = {math.exp(here[-1]):.6g}") from None
            continue
        if family.amplitude(vector) < RETURNED:
            return
        if not limits[0] <= math.exp(vector[-1]) <= limits[1]:
            yield from last_point(family, here, vector, tangent, limits)
            return
        if obstacle := family.base.obstacle(vector[:-1]):
            raise RunFailed(f"the branch {obstacle} at {family.parameter} = {math.exp(vector[-1]):.6g}")
        yield Point(vector, tangent)
        here, direction = vector, tangent
        step = min(longest, step * LONGER) if iterations <= EASY else step


def last_point(
    family: Family, inside: np.ndarray, outside: np.ndarray, tangent: np.ndarray, limits: tuple[float, float]
) -> Iterator[Point]:
    """The point where the branch crosses a limit; nothing if Newton's method does not find it."""
    limit = limits[0] if math.exp(outside[-1]) < limits[0] else limits[1]
    share = (math.log(limit) - inside[-1]) / (outside[-1] - inside[-1])
    try:
        vector = family.at_value(limit, inside + share * (outside - inside))
    except NotConverged:
        return
    yield Point(vector, family.tangent(vector, tangent))


def fold_between(family: Family, before: Point, after: Point) -> Point | None:
    """The fold between two neighbouring points, where the parameter turns back; None if there is none."""
    if before.tangent[-1] * after.tangent[-1] >= 0.0:
        return None
    for _ in range(FOLD_ITERATIONS):
        share = before.tangent[-1] / (before.tangent[-1] - after.tangent[-1])
        direction = after.vector - before.vector
        vector, _ = family.corrected(between(family, before, after, share), direction / family.length(direction))
        middle = Point(vector, family.tangent(vector, direction / family.length(direction)))
        if middle.tangent[-1] * before.tangent[-1] > 0.0:
            before = middle
        else:
            after = middle
    return middle


def between(family: Family, before: Point, after: Point, share: float) -> np.ndarray:
    """The cubic through two points along their tangents, at a share of the way."""
    gap = family.length(after.vector - before.vector)
    rest = 1.0 - share
    ends = rest**2 * (1.0 + 2.0 * share) * before.vector + share**2 * (1.0 + 2.0 * rest) * after.vector
    return ends + gap * share * rest * (rest * before.tangent - share * after.tangent)
