"""Steady states of the box: the extended one, and those with clusters.

A state with m half-waves across the box is a chain: the state of a box m times less wide, with one cluster in its
corner, and its mirror images in turn. So one half-wave is solved for and repeated.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.optimize import brentq

from hydro.choices import SEARCHES
from hydro.errors import RunFailed
from hydro.gas import Closure
from hydro.gas.packing import density_at, log_void
from hydro.mesh import Mesh
from hydro.state import State
from hydro.steady.balance import Balance
from hydro.steady.newton import Solution, relax, solve
from hydro.steady.problem import NotConverged

COARSEST = 16  # cells along a side on which a state is looked for; finer meshes refine it
SEARCHED = 3  # meshes on which it is looked for: near a fold it may not exist on the coarsest
PUSHES = (1.5, 0.5)  # of w toward one side, at the start
UNIFORM = 1e-4  # variation of w along the wall x = 0 below which a state counts as uniform in y


@dataclass(frozen=True, eq=False)
class SteadyState:
    """A solution of `balance` in the whole box, with `wave` half-waves across."""

    balance: Balance
    wave: int
    unknowns: np.ndarray
    iterations: int
    residual: float

    @property
    def state(self) -> State:
        """As a state of the evolution code, at rest."""
        return self.balance.state(self.unknowns)

    @property
    def mirrored(self) -> bool:
        """Whether the state is its own mirror image about the middle of the box in y."""
        return self.wave % 2 == 0


def extended_solution(balance: Balance) -> Solution:
    """The state uniform in y, on a mesh with one cell in y; from a stripe of gas that relaxes."""
    start = balance.unknowns(log_void(balance.gas, balance.area_fraction), guessed_pressure(balance))
    return solve(balance, relax(balance, start))


def steady_state(
    gas: Closure,
    wall: Any,
    mesh: Mesh,
    area_fraction: float,
    wave: int,
    shifted: bool = False,
    search: str = "relaxation",
) -> SteadyState:
    """The steady state with `wave` half-waves in y.

    wave = 0 is the extended state. The first cluster is in the corner y = 0, or, `shifted`, half a wave from it. The
    cells in y must be a multiple of `wave`. search: a name in SEARCHES, for the case that there are several states.
    RunFailed if the search ends in the extended state, or nowhere.
    """
    cell = unit_cell(mesh, wave)
    balance = Balance.of(gas, wall, cell, area_fraction)
    found = SEARCHES[search](balance) if wave else extended_solution(balance)
    whole = Balance.of(gas, wall, mesh, area_fraction)
    unknowns = chain(found.unknowns, cell, mesh, shifted)
    return SteadyState(whole, wave, unknowns, found.iterations, found.residual)


def unit_cell(mesh: Mesh, wave: int) -> Mesh:
    """The mesh of one half-wave; for wave = 0, one cell in y over the whole box."""
    count = mesh.cells[1] // wave if wave else 1
    width = mesh.aspect_ratio / max(wave, 1)
    return Mesh(mesh.x_faces, np.linspace(0.0, width, count + 1))


def chain(unknowns: np.ndarray, cell: Mesh, mesh: Mesh, shifted: bool) -> np.ndarray:
    """Unknowns of the whole box from those of a half-wave, mirrored again and again."""
    w = unknowns[:-1].reshape(cell.cells)
    links = [w, w[:, ::-1]] if not shifted else [w[:, ::-1], w]
    count = mesh.cells[1] // cell.cells[1]
    return np.append(np.concatenate([links[k % 2] for k in range(count)], axis=1), unknowns[-1])


def relaxed(balance: Balance) -> Solution:
    """The state that a gas pushed to y = 0 settles in, looked for on coarse meshes and refined."""
    meshes = ladder(balance.mesh)
    tried = []
    for level, mesh in enumerate(meshes[:SEARCHED]):
        coarse = balance.on(mesh)
        for push in PUSHES:
            words = f"on {mesh.cells[0]} x {mesh.cells[1]} cells, from the extended state pushed by {push:g}: "
            try:
                found = solve(coarse, relax(coarse, pushed(coarse, push)))
                if variation(found, mesh) > UNIFORM:
                    return refined(balance, meshes[level:], found)
                tried.append(words + "the extended state again")
            except NotConverged as error:
                tried.append(words + str(error))
    raise RunFailed("no localized state found:\n  " + "\n  ".join(tried))


def refined(balance: Balance, meshes: list[Mesh], found: Solution) -> Solution:
    """The state carried from mesh to mesh."""
    for before, after in pairwise(meshes):
        finer = balance if after is balance.mesh else balance.on(after)
        step = solve(finer, interpolated(found.unknowns, before, after))
        found = Solution(step.unknowns, found.iterations + step.iterations, step.residual)
    return found


def ladder(mesh: Mesh) -> list[Mesh]:
    """Meshes from coarse to `mesh`, each with about half the cells of the next along every side that has enough."""
    meshes = [mesh]
    while max(meshes[0].cells) >= 2 * COARSEST:
        x_faces, y_faces = (halved(faces) for faces in (meshes[0].x_faces, meshes[0].y_faces))
        meshes.insert(0, Mesh(x_faces, y_faces))
    return meshes


def halved(faces: np.ndarray) -> np.ndarray:
    """Half as many cells of the same relative widths; as they are, if they are few."""
    count = faces.size - 1
    if count < 2 * COARSEST:
        return faces
    return np.interp(np.linspace(0, count, (count + 1) // 2 + 1), np.arange(count + 1), faces)


def interpolated(unknowns: np.ndarray, before: Mesh, after: Mesh) -> np.ndarray:
    """Unknowns on another mesh of the same box, linear between cell centres."""
    w = unknowns[:-1].reshape(before.cells)
    w = np.array([np.interp(after.x, before.x, column) for column in w.T]).T
    w = np.array([np.interp(after.y, before.y, row) for row in w])
    return np.append(w, unknowns[-1])


def pushed(balance: Balance, push: float) -> np.ndarray:
    """The extended state with gas pushed to y = 0: w less push cos(pi y/aspect_ratio), and a constant for the mass."""
    mesh = balance.mesh
    stripe = balance.on(unit_cell(mesh, 0))
    extended = extended_solution(stripe).unknowns
    w = extended[:-1, None] - push * np.cos(np.pi * mesh.y / mesh.aspect_ratio)

    def excess(lift: float) -> float:
        return mesh.integral(density_at(balance.gas, w + lift)) - balance.area_fraction * mesh.aspect_ratio

    return balance.unknowns(w + brentq(excess, -2.0 * push, 2.0 * push), np.exp(extended[-1]))


def guessed_pressure(balance: Balance) -> float:
    """A pressure to start from: that of the mean density at temperature one."""
    return float(balance.gas.pressure(balance.area_fraction, 1.0))


def variation(found: Solution, mesh: Mesh) -> float:
    """Largest less smallest w in the row of cells at x = 0."""
    return float(np.ptp(found.unknowns[:-1].reshape(mesh.cells)[0]))
