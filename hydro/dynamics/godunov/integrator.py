"""The explicit integrator: Strang splitting of the hydrodynamic update, heat and the other terms.

One step is half of (sources and forces, heat, drag, stress), the whole hydrodynamic update, and the other half,
backwards: second-order accurate, for heat acts at frozen density and velocity and so commutes with drag. Drag is exact.
A steady state leaves each part at rest by itself, hence is a fixed point for every step size.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterable, Iterator
from typing import Any, ClassVar

import numba
import numpy as np
from numba import prange

from hydro.accounts import COLLISIONS, WALL, Amounts
from hydro.choices import LIMITERS, RIEMANN_SOLVERS
from hydro.dynamics.godunov import hancock, heat
from hydro.dynamics.godunov.fallback import Fallen, careful
from hydro.dynamics.godunov.ghosts import fill_ghosts
from hydro.dynamics.integrator import Integrator, Remedy, flow_accounts, flow_limits
from hydro.errors import StepRejected
from hydro.fields import MX, MY, E, N
from hydro.gas import Closure
from hydro.jit import kernel, part
from hydro.mesh import GHOSTS, Geometry, Mesh
from hydro.numerics.reduce import store_largest
from hydro.setup import elastic_below
from hydro.state import ROUND_OFF, State, worst_cell
from hydro.terms import Term, Terms
from hydro.terms.together import Given
from hydro.walls.boundary import REMEMBERED, Boundary

FIRST_ORDER, UNSTRESSED = "first_order_cells", "unstressed_cells"
COUNTS = {
    FIRST_ORDER: ("updates of a cell by first-order fluxes, to keep it admissible", "1"),
    UNSTRESSED: ("updates of a cell without stress, to keep it admissible", "1"),
}
NO_CELLS = np.empty((0, 2), int)
CELLS_PER_THREAD = 4096  # fewer are not worth waking a thread for


class Godunov(Integrator):
    """Unsplit MUSCL-Hancock finite volumes with RKL2 conduction, cooling and viscosity.

    walls: the law of the driving wall at x = 1, or `Walls`. terms: beside flow and heat; see `hydro.terms`.
    elastic_below: see `hydro.gas.elastic`. State and work space take 176 bytes per cell. ValueError for a mesh of a
    single cell between walls.
    """

    remembered: ClassVar = {**REMEMBERED, **COUNTS}
    remedies = (Remedy("scheme.limiter=minmod", lambda deck: deck.scheme.limiter != "minmod"),)
    seconds_per_cell_step, bytes_per_cell = 8e-8, 176

    @staticmethod
    def options(deck: Any) -> dict[str, Any]:
        return {
            "cfl": deck.time.cfl,
            "limiter": deck.scheme.limiter,
            "riemann": deck.scheme.riemann,
            "elastic_below": elastic_below(deck),
        }

    def __init__(
        self,
        gas: Closure,
        walls: Any,
        mesh: Mesh,
        terms: Iterable[Term] = (),
        cfl: float = 0.8,
        limiter: str = "van_leer",
        riemann: str = "hllc_lm",
        elastic_below: float = 0.0,
    ):
        if any(count < GHOSTS and not wraps for count, wraps in zip(mesh.cells, mesh.periodic, strict=True)):
            raise ValueError(f"{mesh.cells} cells: {GHOSTS} or more are needed between walls")
        self.threads = threads = worth_threads(mesh)
        self.gas, self.mesh, self.terms, self.cfl = gas, mesh, Terms(terms), cfl
        self.accounts, self.step_limits = flow_accounts(self.terms), flow_limits(self.terms)
        self.boundary = Boundary(gas, walls, mesh)
        self._limiter, self._riemann = LIMITERS[limiter], RIEMANN_SOLVERS[riemann]
        self._geometry = Geometry.of(mesh)
        self._heat = heat.Heat(gas, self.boundary, mesh, threads, elastic_below) if gas.conducts() else None
        self.stresses = self.terms.stresses(gas, self.boundary, mesh)
        self._half, self._next = np.empty((4, *mesh.cells)), np.empty((4, *mesh.cells))
        self._fallen, self._counts = Fallen.none(mesh), dict.fromkeys(COUNTS, 0)
        self._scratch, self._rates = hancock.scratch_for(threads), np.empty(mesh.cells[0])

    def limits(self, state: State) -> dict[str, float]:
        """Sound: cfl times the time in which the fastest signal crosses half a cell; zero for an inadmissible state."""
        with thread_count(self.threads):
            signal_rates(self.gas, self._geometry, state.conserved, self._half[0], self._rates)
        return {"sound": self.cfl / float(self._rates.max()), **self.terms.limits(state)}

    def step(self, state: State, dt: float) -> dict[str, float]:
        """Advance `state` in place by `dt`; StepRejected, if n or T would leave its bounds, leaves it untouched.

        Where they would do so by the second-order update, that falls back to first order.
        """
        before = self.memory()
        try:
            try:
                booked = self._advance(state, dt, self._flow, self._apply_stresses)
            except StepRejected:
                self.remember(before)
                booked = self._advance(state, dt, self._careful_flow, self._careful_stresses)
        except StepRejected:
            self.remember(before)
            raise
        state.conserved[:] = self._next
        state.time += dt
        return booked

    def _advance(self, state: State, dt: float, flow: Callable[..., None], stresses: Callable[..., None]) -> Amounts:
        """The state `dt` after `state` into `self._next`, by these updates; what is to be booked."""
        booked = Amounts.of(self.accounts)
        rates = self.terms.rates(state.time + 0.5 * dt, self.mesh)
        for account, field in rates:
            booked.add_to(account, dt * self.mesh.integral(field[E]))
        before, after = self._half, self._next
        before[:] = state.conserved
        with thread_count(self.threads):
            self._apply_sources(rates, before, dt)
            self._apply_forces(before, state.time, 0.5 * dt, booked)
            self._heat_and_drag(before, 0.5 * dt, booked)
            stresses(before, 0.5 * dt)
            flow(before, after, dt)
            stresses(after, 0.5 * dt)
            self._heat_and_drag(after, 0.5 * dt, booked)
            self._apply_forces(after, state.time + dt, 0.5 * dt, booked)
            self._apply_sources(rates, after, dt)
            signal_rates(self.gas, self._geometry, after, before[0], self._rates)
        if math.isnan(booked[WALL.name]) or not self._rates.max() < math.inf:
            raise StepRejected(self._reason(booked[WALL.name], dt))
        return booked

    def _reason(self, wall: float, dt: float) -> str:
        """Why a step is rejected: where heat is too fast, or which cell would be inadmissible."""
        if math.isnan(wall) and self._heat is not None:
            x = self.mesh.x[np.argmax(self._heat.arrays.sums[heat.RATE])]
            return f"conduction or cooling is too fast for dt = {dt:.3g}, most of all at x = {x:.4g}"
        return worst_cell(State(self.gas, self.mesh, self._next))

    def _apply_sources(self, rates: list[Given], state: np.ndarray, dt: float) -> None:
        """Half of the rates over the whole step."""
        for _, field in rates:
            state += 0.5 * dt * field

    def _apply_forces(self, state: np.ndarray, time: float, dt: float, booked: Amounts) -> None:
        """The forces at `time` for `dt`: exact in momentum and energy if they are constant."""
        forces = self.terms.forces(time, State(self.gas, self.mesh, state, time))
        if not forces:
            return
        change = dt * state[N] * sum(force for _, force in forces)
        middle = state[MX:E] + 0.5 * change
        for account, force in forces:
            work = dt * (middle * force).sum(axis=0)
            state[E] += work
            booked.add_to(account, self.mesh.integral(work))
        state[MX:E] += change

    def _heat_and_drag(self, state: np.ndarray, dt: float, booked: Amounts) -> None:
        """Heat and drag for `dt`."""
        if self._heat is not None:
            given, lost = self._heat.advance(state, dt)
            booked.add({WALL.name: given, COLLISIONS.name: lost})
        if self.terms.drag_rate > 0.0:
            lost = apply_drag(self._geometry, state, math.exp(-dt * self.terms.drag_rate))
            booked.add(self.terms.drag_losses(lost))

    def _apply_stresses(self, state: np.ndarray, dt: float, spared: np.ndarray = NO_CELLS) -> None:
        """Stresses for `dt`, but for some cells."""
        for stress in self.stresses:
            stress.advance(state, dt, spared)

    def _careful_stresses(self, state: np.ndarray, dt: float) -> None:
        """Stresses for `dt`, but for cells that would be inadmissible by them."""
        before = state.copy()

        def update(cells: np.ndarray) -> None:
            state[:] = before
            self._apply_stresses(state, dt, np.argwhere(cells))

        self._counts[UNSTRESSED] += careful(update, State(self.gas, self.mesh, state))

    def _careful_flow(self, before: np.ndarray, after: np.ndarray, dt: float) -> None:
        """The hydrodynamic update, of first order in cells that would be inadmissible by that of second order."""

        def update(cells: np.ndarray) -> None:
            self._fallen.let(cells, self.mesh.periodic)
            self._flow(before, after, dt)

        self._counts[FIRST_ORDER] += careful(update, State(self.gas, self.mesh, after))
        self._fallen.let(np.zeros(self.mesh.cells, bool), self.mesh.periodic)

    def _flow(self, before: np.ndarray, after: np.ndarray, dt: float) -> None:
        """The hydrodynamic update."""
        boundary = self.boundary
        fill_ghosts(self.gas, boundary.laws_beyond, self.mesh.periodic, before, boundary.sides)
        hancock.advance(
            self.gas, self._limiter, self._riemann, dt, self._geometry, boundary.sides, self._fallen, before, after,
            self._scratch,
        )  # fmt: skip

    def memory(self) -> dict[str, np.ndarray]:
        """Temperatures of the walls, first guesses of the next solve for them; how often cells fell back."""
        return {**self.boundary.temperatures(), **{name: np.array([count]) for name, count in self._counts.items()}}

    def remember(self, memory: dict[str, np.ndarray]) -> None:
        """Take back what `memory` gave."""
        self.boundary.take_temperatures(memory)
        self._counts = {name: int(memory.get(name, [0])[0]) for name in COUNTS}

    def counts(self) -> dict[str, int]:
        return dict(self._counts)


def worth_threads(mesh: Mesh) -> int:
    """As many threads as numba may use, but not more than the mesh keeps busy."""
    nx, ny = mesh.cells
    return max(1, min(numba.get_num_threads(), nx * ny // CELLS_PER_THREAD, nx))


@contextlib.contextmanager
def thread_count(threads: int) -> Iterator[None]:
    """Use so many threads in kernels; a small mesh is faster without waking others."""
    before = numba.get_num_threads()
    if before != threads:
        numba.set_num_threads(threads)
    try:
        yield
    finally:
        if before != threads:
            numba.set_num_threads(before)


@kernel
def apply_drag(geometry, state, keep):
    """Slow the flow to `keep` of its velocity; returns the energy that takes."""
    lost = 0.0
    for i in range(state.shape[1]):
        width = geometry.scale[i] * geometry.dx[i]
        lost += width * drag_row(state[N, i], state[MX, i], state[MY, i], state[E, i], geometry.dy, keep)
    return lost


@part
def drag_row(density, momentum_x, momentum_y, energy, dy, keep):
    """Drag in one row of cells; returns the energy lost per width."""
    lost = 0.0
    for j in range(np.uint64(density.size)):
        kinetic = 0.5 * (momentum_x[j] * momentum_x[j] + momentum_y[j] * momentum_y[j]) / density[j]
        loss = (1.0 - keep * keep) * kinetic
        momentum_x[j] *= keep
        momentum_y[j] *= keep
        energy[j] -= loss
        lost += loss * dy[j]
    return lost


@kernel(parallel=True)
def signal_rates(gas, geometry, state, work, rates):
    """Per row the largest rate at which signals cross half a cell, shape (nx,); infinite where n or T is out of bounds.

    Half a cell, because the update is unsplit, and because it is unstable beyond, in one direction already, without
    the acoustic dissipation of velocity jumps that Riemann solvers for low Mach numbers leave out.
    work: (nx, ny), overwritten.
    """
    for i in prange(state.shape[1]):
        over_dx, scale = 1.0 / geometry.dx[i], geometry.scale[i]
        signal_rate_row(gas, state[N, i], state[MX, i], state[MY, i], state[E, i], over_dx, scale, geometry.dy, work[i])
        store_largest(work[i], rates, i)


@part
def signal_rate_row(gas, density, momentum_x, momentum_y, energy, over_dx, scale, dy, rates):
    """Signal rates of one row of cells."""
    packed = gas.packing_density()
    for j in range(np.uint64(density.size)):
        n = density[j]
        over = 1.0 / n
        u, v = abs(momentum_x[j] * over), abs(momentum_y[j] * over)
        flow = 0.5 * (u * u + v * v)
        T = energy[j] * over - flow
        c = gas.sound_speed_at_pressure(n, gas.pressure(n, T))
        rate = 2.0 * max((u + c) * over_dx, (v + c) / (scale * dy[j]))
        allowed = (n > 0.0) & (n < packed) & (T - ROUND_OFF * flow > 0.0) & (rate < np.inf)
        rates[j] = rate if allowed else np.inf
