"""Newton's method for steady states, and the relaxation that leads into its reach."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from hydro.steady.linear import Bordered, Singular
from hydro.steady.operators import diagonal
from hydro.steady.problem import NotConverged, Problem

ITERATIONS = 40
CLOSE = 1e-8  # a step of the unknowns after which the error is round-off
STALLED = 100.0  # round-offs that a residual may be left with when no step makes it smaller
LONGEST_STEP = 2.0  # of any unknown in one iteration
SHORTEST_SHARE = 1e-3  # of a step, before the line search gives up
DESCENT = 0.1

RELAXATIONS = 400
FIRST_TIME_STEP, LAST_TIME_STEP = 0.03, 300.0  # in cooling times of the mean gas
CALM = 0.5  # a change of the unknowns in one relaxation step that asks for a longer one
STORMY = 3.0  # and one that asks for a repetition with a shorter one
BORDER_STEP = 2.0  # of the unknowns coupled to all, in one relaxation step
SETTLED = 0.02


class Solution(NamedTuple):
    """Unknowns (N + k,), iterations taken, largest residual relative to its scale."""

    unknowns: np.ndarray
    iterations: int
    residual: float


def solve(problem: Problem, start: np.ndarray) -> Solution:
    """The steady state near `start`; NotConverged where there seems to be none."""
    problem.refuse(start)
    u, scale = start, problem.scale(start)
    residual = problem.residual(u)
    for iteration in range(1, ITERATIONS + 1):
        try:
            step = newton_step(problem, u, residual)
        except Singular:
            break
        size = float(np.max(np.abs(step)))
        share = line_search(lambda v: norm(problem.residual(v), scale), u, step, norm(residual, scale))
        if not np.isfinite(size):
            break
        u = u + share * step
        residual = problem.residual(u)
        digits = float(np.max(np.abs(residual) / problem.round_off(u)))
        if size < CLOSE or digits < 1.0 or (share < 1.0 and digits < STALLED):
            return Solution(u, iteration, float(np.max(np.abs(residual / problem.scale(u)))))
        if share < SHORTEST_SHARE:
            break
    raise NotConverged(
        f"no steady state found from here: after {iteration} Newton iterations on {problem.place} "
        f"the residual is {np.max(np.abs(residual / scale)):.2g} of what it is to be small against"
    )


def norm(residual: np.ndarray, scale: np.ndarray) -> float:
    """Root mean square of the residual over its scale."""
    return float(np.sqrt(np.mean((residual / scale) ** 2)))


def newton_step(problem: Problem, u: np.ndarray, residual: np.ndarray) -> np.ndarray:
    """The change of u that would cancel the residual, were it linear."""
    return Bordered(*problem.slopes(u)).solve(-residual)


def line_search(merit: Callable[[np.ndarray], float], u: np.ndarray, step: np.ndarray, before: float) -> float:
    """The share of a step that makes the merit smaller; near a solution, where round-off decides, the whole step."""
    size = float(np.max(np.abs(step)))
    if size < CLOSE:
        return 1.0
    share = min(1.0, LONGEST_STEP / size)
    while share >= SHORTEST_SHARE and not merit(u + share * step) < (1.0 - DESCENT * share) * before:
        share *= 0.5
    return share


def relax(problem: Problem, start: np.ndarray) -> np.ndarray:
    """Follow the gas from `start` to where it settles, by pseudo-transient continuation.

    Cells that are heated more than cooled expand, the others contract, at a pressure that keeps the mass: implicit
    steps of growing length (Kelley and Keyes, SIAM J. Numer. Anal. 35, 508, 1998). The path has no meaning; steady
    states of this motion are those of the gas. `start` must hold the right mass.
    """
    u, dt = start, FIRST_TIME_STEP
    for _ in range(RELAXATIONS):
        problem.refuse(u)
        slopes = problem.slopes(u)
        inertia = diagonal(problem.capacity(u) / dt)
        try:
            bordered = Bordered((slopes.matrix - inertia).tocsc(), *slopes[1:])
            step = bordered.solve(-problem.residual(u))
        except Singular:
            dt *= 0.25
            continue
        count = slopes.matrix.shape[0]
        size = float(np.max(np.abs(step[:count])))
        if not size < STORMY:
            dt *= 0.25
            continue
        step[count:] = np.clip(step[count:], -BORDER_STEP, BORDER_STEP)
        u = u + step
        if size < SETTLED and dt >= LAST_TIME_STEP:
            return u
        dt = min(dt * (1.6 if size < CALM else 0.8), 1e3 * LAST_TIME_STEP)
    return u
