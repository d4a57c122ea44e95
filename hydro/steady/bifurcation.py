"""Where branches of localized states leave the extended state, and the state that is found along one."""

from __future__ import annotations

import contextlib
import math
from collections import deque
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from hydro.errors import RunFailed
from hydro.steady.balance import Balance, Local
from hydro.steady.continuation import Family, Point, follow
from hydro.steady.localized import extended_solution, ladder, refined, unit_cell
from hydro.steady.newton import Solution, solve
from hydro.steady.problem import NotConverged

SEARCH_CELLS = 64  # along a side, at most, of the mesh on which a state is looked for on a branch
SEARCH_STEP = 0.2
REACH, SAMPLES = 1.5, 17  # factor to both sides of f within which bifurcations are looked for, and states tried


class ExtendedBranch:
    """The extended states of a family, on a mesh of one cell in y, and what one half-wave does to them."""

    def __init__(self, family: Family[Balance]):
        self.family = family
        cell = family.base.mesh
        self.stripe = family.base.on(unit_cell(cell, 0))
        self._cells = cell.cells[1]
        self._last: np.ndarray | None = None

    def balance(self, value: float) -> Balance:
        """The one-dimensional problem."""
        return self.stripe.with_parameter(self.family.parameter, value)

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
        here, matrix = Local.of(balance.gas, unknowns[:-1]), balance.slopes(unknowns).matrix
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


def first_on_branch(balance: Balance) -> Solution:
    """The first state on the branch from the nearest bifurcation in f: beyond a subcritical one, an unstable state."""
    meshes = ladder(balance.mesh)
    while len(meshes) > 1 and max(meshes[1].cells) <= SEARCH_CELLS:
        meshes = meshes[1:]
    family = Family(balance.on(meshes[0]), "f")
    wanted = balance.area_fraction
    values = np.geomspace(wanted / REACH, min(wanted * REACH, 0.5 * (balance.gas.packing_density() + wanted)), SAMPLES)
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
