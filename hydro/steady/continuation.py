"""Branches of steady states: pseudo-arclength continuation in one parameter.

A family holds problems that differ in one parameter: area fraction, aspect ratio or L. A branch is a curve in the space
of (unknowns, parameter); it is followed by its arclength, so that it may turn back at a fold (Keller 1977; see Doedel,
Keller and Kernevez, Int. J. Bifurcation Chaos 1, 493, 1991). Lengths are measured in the root mean square of the
change of log(1/n - 1) over the box and in the change of the logarithm of the parameter.
"""

from __future__ import annotations

import contextlib
import math
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from hydro.errors import RunFailed
from hydro.mesh import Mesh
from hydro.registry import Registry
from hydro.steady.balance import Balance, Local
from hydro.steady.linear import Bordered, Singular
from hydro.steady.localized import SEARCHES, extended_solution, ladder, refined, unit_cell
from hydro.steady.newton import NotConverged, Solution, line_search, norm, solve

PARAMETER_WEIGHT = 10.0  # of a change of log(parameter) against one of log(1/n - 1)
DIFFERENCE = 1e-5  # of log(parameter), for derivatives in it
ITERATIONS = 12
CLOSE = 1e-8
EASY = 4  # iterations after which the next step may be longer
LONGER, SHORTER = 1.4, 0.4
SHORTEST = 1e-3  # step, as a share of the longest
FIRST = 0.25  # step off the extended state, likewise
RETURNED = 1e-3  # amplitude below which a branch is back at the extended state
PACKED = 1e-9  # 1-n below which the cells cannot tell densities apart

FOLD_ITERATIONS = 4
SEARCH_CELLS = 64  # along a side, at most, of the mesh on which a state is looked for on a branch
SEARCH_STEP = 0.2
REACH, SAMPLES = 1.5, 17  # factor to both sides of f within which bifurcations are looked for, and states tried

PARAMETERS: Registry[Callable[[Balance, float], Balance]] = Registry("parameter")


@PARAMETERS.register("f")
def with_area_fraction(balance: Balance, value: float) -> Balance:
    """The problem with another area fraction."""
    return replace(balance, area_fraction=value)


@PARAMETERS.register("L")
def with_loss(balance: Balance, value: float) -> Balance:
    """The problem with another collisional loss."""
    return replace(balance, gas=balance.gas._replace(L=value))  # type: ignore[attr-defined]


@PARAMETERS.register("aspect_ratio")
def with_aspect_ratio(balance: Balance, value: float) -> Balance:
    """The problem in a box of another width; `value` is the aspect ratio of the balance's own mesh."""
    mesh = balance.mesh
    return balance.on(Mesh(mesh.x_faces, mesh.y_faces * (value / mesh.aspect_ratio)))


class Family:
    """Steady problems on one half-wave that differ in a parameter; vectors are (w, log p, log parameter)."""

    def __init__(self, balance: Balance, parameter: str):
        self.base, self.parameter = balance, parameter
        self._with = partial(PARAMETERS[parameter], balance)

    def at(self, log_value: float) -> Balance:
        """The problem for a value of the parameter."""
        return self._with(math.exp(log_value))

    def residual(self, vector: np.ndarray) -> np.ndarray:
        """That of the problem, (cells + 1,)."""
        return self.at(vector[-1]).residual(vector[:-1])

    def in_parameter(self, vector: np.ndarray) -> np.ndarray:
        """Derivative of the residual in log(parameter), (cells + 1,)."""
        up, down = (self.at(vector[-1] + shift).residual(vector[:-1]) for shift in (DIFFERENCE, -DIFFERENCE))
        return (up - down) / (2.0 * DIFFERENCE)

    def dual(self, vector: np.ndarray) -> np.ndarray:
        """The row whose product with a change gives the inner product with `vector`."""
        areas = self.base.areas / self.base.areas.sum()
        return np.concatenate([areas * vector[:-2], [0.0, PARAMETER_WEIGHT**2 * vector[-1]]])

    def length(self, vector: np.ndarray) -> float:
        """The length of a change."""
        return float(np.sqrt(self.dual(vector) @ vector))

    def bordered(self, vector: np.ndarray, row: np.ndarray) -> Bordered:
        """The derivative of the residual, with `row` for the condition that fixes the place along the branch."""
        matrix, in_log_p, mass = self.at(vector[-1]).slopes(vector[:-1])
        in_parameter = self.in_parameter(vector)
        columns = np.stack([in_log_p, in_parameter[:-1]], axis=1)
        corner = np.array([[0.0, in_parameter[-1]], row[-2:]])
        return Bordered(matrix, columns, np.stack([mass, row[:-2]]), corner)

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
        """How much denser the row x = 0 is at y = 0 than at the other end: minus the cosine component of w there."""
        mesh = self.base.mesh
        w = vector[:-2].reshape(mesh.cells)[0]
        return float(-2.0 * np.mean(w * np.cos(np.pi * (np.arange(w.size) + 0.5) / w.size)))


@dataclass(frozen=True, eq=False)
class Point:
    """A point of a branch: its vector and unit tangent; where a branch leaves the extended state, the way it leaves."""

    vector: np.ndarray
    tangent: np.ndarray

    @property
    def value(self) -> float:
        """The parameter."""
        return math.exp(self.vector[-1])


class ExtendedBranch:
    """The extended states of a family, on a mesh of one cell in y, and what one half-wave does to them."""

    def __init__(self, family: Family):
        self.family = family
        cell = family.base.mesh
        self.stripe = family.base.on(unit_cell(cell, 0))
        self._cells = cell.cells[1]
        self._last: np.ndarray | None = None

    def balance(self, value: float) -> Balance:
        """The one-dimensional problem."""
        return PARAMETERS[self.family.parameter](self.stripe, value)

    def unknowns(self, value: float) -> np.ndarray:
        """The extended state, (nx + 1,); from the last one, if that is near enough."""
        balance = self.balance(value)
        if self._last is not None:
            with contextlib.suppress(NotConverged):
                self._last = solve(balance, self._last).unknowns
                return self._last
        self._last = extended_solution(balance).unknowns
        return self._last

    def vector(self, value: float) -> np.ndarray:
        """The extended state as a vector of the family."""
        unknowns = self.unknowns(value)
        w = np.repeat(unknowns[:-1], self._cells)
        return np.concatenate([w, [unknowns[-1], math.log(value)]])

    def half_wave(self, value: float) -> tuple[float, np.ndarray]:
        """The leading eigenvalue of the heating of cells under a change ~ cos(pi y/aspect_ratio), and the change (nx,).

        It is zero where a branch leaves, positive where the extended state gives way.
        """
        balance, unknowns = self.balance(value), self.unknowns(value)
        here, (matrix, _, _) = Local.of(balance.gas, unknowns[:-1]), balance.slopes(unknowns)
        width = balance.mesh.aspect_ratio / self._cells
        rate = (2.0 / width * math.sin(0.5 * math.pi / self._cells)) ** 2
        across = matrix.toarray() - np.diag(rate * balance.areas * here.kappa * here.T_w)
        values, vectors = np.linalg.eig(across / balance.areas[:, None])
        leading = int(np.argmax(values.real))
        return float(values[leading].real), vectors[:, leading].real

    def bifurcations(self, values: np.ndarray) -> list[Point]:
        """Where the half-wave changes from growing to decaying, between neighbours of `values`."""
        rates = [self.half_wave(value)[0] for value in values]
        found = []
        for (low, below), (high, above) in pairwise(zip(values, rates, strict=True)):
            if below * above <= 0.0:
                found.append(self._bifurcation(brentq(lambda value: self.half_wave(value)[0], low, high, rtol=1e-12)))
        return found

    def _bifurcation(self, value: float) -> Point:
        _, change = self.half_wave(value)
        change = change * -np.sign(change[0])  # denser at y = 0
        wave = np.cos(np.pi * (np.arange(self._cells) + 0.5) / self._cells)
        direction = np.concatenate([np.outer(change, wave).ravel(), [0.0, 0.0]])
        return Point(self.vector(value), direction / self.family.length(direction))


def follow(family: Family, start: Point, limits: tuple[float, float], longest: float) -> Iterator[Point]:
    """The points of the branch that leaves the extended state at `start`, until it leaves the limits or returns.

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
        if np.min(vector[:-2]) < math.log(PACKED):
            raise RunFailed(f"the branch reaches close packing at {family.parameter} = {math.exp(vector[-1]):.6g}")
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


@SEARCHES.register("branch")
def first_on_branch(balance: Balance) -> Solution:
    """The first state on the branch from the nearest bifurcation in f: beyond a subcritical one, an unstable state."""
    meshes = ladder(balance.mesh)
    while len(meshes) > 1 and max(meshes[1].cells) <= SEARCH_CELLS:
        meshes = meshes[1:]
    family = Family(balance.on(meshes[0]), "f")
    wanted = balance.area_fraction
    values = np.geomspace(wanted / REACH, min(wanted * REACH, 0.5 * (1.0 + wanted)), SAMPLES)
    starts = ExtendedBranch(family).bifurcations(values)
    lost: list[str] = []
    for start in sorted(starts, key=lambda found: abs(math.log(found.value / wanted))):
        limits = (values[0], wanted) if start.value < wanted else (wanted, values[-1])
        try:
            ends = deque(follow(family, start, limits, SEARCH_STEP), maxlen=1)
        except RunFailed as error:
            lost.append(f"\n  from {start.value:.5g}: {error}")
            continue
        if ends and math.isclose(ends[0].value, wanted, rel_tol=1e-12):
            return refined(balance, meshes, solve(family.at(ends[0].vector[-1]), ends[0].vector[:-1]))
    tried = ", ".join(f"{start.value:.5g}" for start in starts) or "none"
    nearby = f"bifurcations of the extended state nearby: {tried}"
    raise RunFailed(f"no branch comes to f = {wanted:g}; {nearby}{''.join(lost)}")
