"""Newton's method for steady states, and the relaxation that leads into its reach."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from hydro.errors import RunFailed
from hydro.steady.balance import Balance
from hydro.steady.linear import Bordered, Singular
from hydro.steady.operators import diagonal

ITERATIONS = 40
LOWEST = -30.0  # of log(1/n - 1): closer to close packing n is a number too coarse to work with
CLOSE = 1e-8  # a step of w and log p after which the error is round-off
STALLED = 100.0  # round-offs that a residual may be left with when no step makes it smaller
LONGEST_STEP = 2.0  # of w or log p in one iteration
SHORTEST_SHARE = 1e-3  # of a step, before the line search gives up
DESCENT = 0.1

RELAXATIONS = 400
FIRST_TIME_STEP, LAST_TIME_STEP = 0.03, 300.0  # in cooling times of the mean gas
CALM = 0.5  # a change of w in one relaxation step that asks for a longer one
STORMY = 3.0  # and one that asks for a repetition with a shorter one
PRESSURE_STEP = 2.0  # of log p, in one relaxation step
SETTLED = 0.02


class Solution(NamedTuple):
    """Unknowns (cells + 1,), iterations taken, largest residual relative to `Balance.scale`."""

    unknowns: np.ndarray
    iterations: int
    residual: float


class NotConverged(RunFailed):
    """Newton's method found no steady state from its start; says how far it got."""


def solve(balance: Balance, start: np.ndarray) -> Solution:
    """The steady state near `start`; NotConverged where there seems to be none."""
    refuse_packed(balance, start)
    u, scale = start, balance.scale(start)
    residual = balance.residual(u)
    for iteration in range(1, ITERATIONS + 1):
        try:
            step = newton_step(balance, u, residual)
        except Singular:
            break
        size = float(np.max(np.abs(step)))
        share = line_search(lambda v: norm(balance.residual(v), scale), u, step, norm(residual, scale))
        if not np.isfinite(size):
            break
        u = u + share * step
        residual = balance.residual(u)
        digits = float(np.max(np.abs(residual) / balance.round_off(u)))
        if size < CLOSE or digits < 1.0 or (share < 1.0 and digits < STALLED):
            return Solution(u, iteration, float(np.max(np.abs(residual / balance.scale(u)))))
        if share < SHORTEST_SHARE:
            break
    raise NotConverged(
        f"no steady state found from here: after {iteration} Newton iterations on {balance.mesh.cells[0]} x "
        f"{balance.mesh.cells[1]} cells the residual is {np.max(np.abs(residual / scale)):.2g} of the mean cooling"
    )


def norm(residual: np.ndarray, scale: np.ndarray) -> float:
    """Root mean square of the residual over its scale."""
    return float(np.sqrt(np.mean((residual / scale) ** 2)))


def newton_step(balance: Balance, u: np.ndarray, residual: np.ndarray) -> np.ndarray:
    """The change of u that would cancel the residual, were it linear."""
    matrix, in_log_p, mass = balance.slopes(u)
    return Bordered(matrix, in_log_p[:, None], mass[None, :], np.zeros((1, 1))).solve(-residual)


def line_search(merit: Callable[[np.ndarray], float], u: np.ndarray, step: np.ndarray, before: float) -> float:
    """The share of a step that makes the merit smaller; near a solution, where round-off decides, the whole step."""
    size = float(np.max(np.abs(step)))
    if size < CLOSE:
        return 1.0
    share = min(1.0, LONGEST_STEP / size)
    while share >= SHORTEST_SHARE and not merit(u + share * step) < (1.0 - DESCENT * share) * before:
        share *= 0.5
    return share


def refuse_packed(balance: Balance, u: np.ndarray) -> None:
    """NotConverged where 1-n falls below what the cells can tell apart."""
    lowest = int(np.argmin(u[:-1]))
    if u[lowest] < LOWEST:
        i, j = np.unravel_index(lowest, balance.mesh.cells)
        raise NotConverged(
            f"no steady state found on {balance.mesh.cells[0]} x {balance.mesh.cells[1]} cells: 1-n falls below "
            f"{np.exp(LOWEST):.0e} at x = {balance.mesh.x[i]:.3g}, y = {balance.mesh.y[j]:.3g}; "
            "smaller f or L avoid that"
        )


def relax(balance: Balance, start: np.ndarray) -> np.ndarray:
    """Follow the gas from `start` to where it settles, by pseudo-transient continuation.

    Cells that are heated more than cooled expand, the others contract, at a pressure that keeps the mass: implicit
    steps of growing length (Kelley and Keyes, SIAM J. Numer. Anal. 35, 508, 1998). The path has no meaning; steady
    states of this motion are those of the gas. `start` must hold the right mass.
    """
    u, dt = start, FIRST_TIME_STEP
    for _ in range(RELAXATIONS):
        refuse_packed(balance, u)
        matrix, in_log_p, mass = balance.slopes(u)
        capacity = balance.scale(u)[0] / balance.areas.mean() * (-mass) / balance.area_fraction
        inertia = diagonal(capacity / dt)
        try:
            bordered = Bordered((matrix - inertia).tocsc(), in_log_p[:, None], mass[None, :], np.zeros((1, 1)))
            step = bordered.solve(-balance.residual(u))
        except Singular:
            dt *= 0.25
            continue
        size = float(np.max(np.abs(step[:-1])))
        if not size < STORMY:
            dt *= 0.25
            continue
        step[-1] = np.clip(step[-1], -PRESSURE_STEP, PRESSURE_STEP)
        u = u + step
        if size < SETTLED and dt >= LAST_TIME_STEP:
            return u
        dt = min(dt * (1.6 if size < CALM else 0.8), 1e3 * LAST_TIME_STEP)
    return u
