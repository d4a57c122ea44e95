"""The explicit integrator: Strang splitting of the hydrodynamic update, heat and friction.

One step is half of (source, heat, friction, viscosity), the whole hydrodynamic update, and the other half, backwards:
second-order accurate, for heat acts at frozen density and velocity and so commutes with friction. Friction is exact. A
steady state leaves each part at rest by itself, hence is a fixed point for every step size.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numba
import numpy as np
from numba import prange

from hydro.dynamics import hancock, heat
from hydro.dynamics import viscosity as viscous_flow
from hydro.dynamics.integrator import INTEGRATORS, Exchange, Integrator, Source, StepRejected
from hydro.dynamics.limiters import LIMITERS
from hydro.dynamics.reduce import store_largest
from hydro.dynamics.riemann import RIEMANN_SOLVERS
from hydro.gas import Closure
from hydro.jit import kernel, part
from hydro.mesh import GHOSTS, Geometry, Mesh
from hydro.state import State, worst_cell

CELLS_PER_THREAD = 4096  # fewer are not worth waking a thread for


class Flow(NamedTuple):
    """What the hydrodynamic update needs beside the states."""

    limiter: Any
    riemann: Any
    spacing_x: np.ndarray
    spacing_y: np.ndarray
    periodic: np.ndarray
    scratch: np.ndarray


@INTEGRATORS.register("godunov")
class Godunov(Integrator):
    """Unsplit MUSCL-Hancock finite volumes with RKL2 conduction, cooling and viscosity.

    See `hancock`, `heat` and `viscosity`. viscosity: of the gas, over that of the closure. `source(time, mesh)`, if
    given, is added to the equations: rates of the four conserved fields, shape (4, nx, ny), taken at mid-step. State
    and work space take 176 bytes per cell, 208 more with viscosity. ValueError for a mesh of a single cell between
    walls.
    """

    def __init__(
        self,
        gas: Closure,
        wall: Any,
        mesh: Mesh,
        tau: float = math.inf,
        cfl: float = 0.8,
        limiter: str = "van_leer",
        riemann: str = "hllc_lm",
        source: Source | None = None,
        viscosity: float = 0.0,
    ):
        if any(count < GHOSTS and not wraps for count, wraps in zip(mesh.cells, mesh.periodic, strict=True)):
            raise ValueError(f"{mesh.cells} cells: {GHOSTS} or more are needed between walls")
        self.threads = threads = worth_threads(mesh)
        self.gas, self.wall, self.mesh, self.tau, self.cfl, self.source = gas, wall, mesh, tau, cfl, source
        self._flow = Flow(
            LIMITERS[limiter], RIEMANN_SOLVERS[riemann], mesh.spacing(0), mesh.spacing(1), np.array(mesh.periodic),
            hancock.scratch_for(threads),
        )  # fmt: skip
        self._geometry = Geometry.of(mesh)
        self._heat = heat.HeatArrays.of(mesh, threads)
        self._viscosity = viscosity if gas.conducts() else 0.0
        self._viscous = viscous_flow.Arrays.of(mesh) if self._viscosity > 0.0 else None
        self._half, self._next = np.empty((4, *mesh.cells)), np.empty((4, *mesh.cells))
        self._rates = np.empty(mesh.cells[0])

    def limits(self, state: State) -> dict[str, float]:
        """Sound: cfl times the time in which the fastest signal crosses half a cell; zero for an inadmissible state."""
        with thread_count(self.threads):
            signal_rates(self.gas, state.conserved, self.mesh.dx, self.mesh.dy, self._half[0], self._rates)
        return {"sound": self.cfl / float(self._rates.max())}

    def step(self, state: State, dt: float) -> Exchange:
        """Advance `state` in place by `dt`; StepRejected, if n or T would leave its bounds, leaves it untouched."""
        guess = self._heat.wall_temperature.copy()
        source = None if self.source is None else self.source(state.time + 0.5 * dt, self.mesh)
        before, after = self._half, self._next
        before[:] = state.conserved
        with thread_count(self.threads):
            self._add(source, before, dt)
            first = self._heat_and_rub(before, 0.5 * dt)
            self._drag(before, 0.5 * dt)
            self._flow_from(before, after, dt)
            self._drag(after, 0.5 * dt)
            second = self._heat_and_rub(after, 0.5 * dt)
            self._add(source, after, dt)
            signal_rates(self.gas, after, self.mesh.dx, self.mesh.dy, before[0], self._rates)
        wall, collisions, friction = np.add(first, second).tolist()
        if math.isnan(wall) or not self._rates.max() < math.inf:
            self._heat.wall_temperature[:] = guess
            raise StepRejected(self._reason(wall, dt))
        state.conserved[:] = after
        state.time += dt
        return Exchange(wall, collisions, friction, 0.0 if source is None else dt * self.mesh.integral(source[3]))

    def _reason(self, wall: float, dt: float) -> str:
        """Why a step is rejected: where heat is too fast, or which cell would be inadmissible."""
        if math.isnan(wall):
            x = self.mesh.x[np.argmax(self._heat.sums[heat.RATE])]
            return f"conduction or cooling is too fast for dt = {dt:.3g}, most of all at x = {x:.4g}"
        return worst_cell(State(self.gas, self.mesh, self._next))

    def _add(self, source: np.ndarray | None, state: np.ndarray, dt: float) -> None:
        """Half of the source over the whole step."""
        if source is not None:
            state += 0.5 * dt * source

    def _heat_and_rub(self, state: np.ndarray, dt: float) -> tuple[float, float, float]:
        """Heat and friction for `dt`; returns the energies given by the wall, lost in collisions and by friction."""
        given, lost, rubbed = 0.0, 0.0, 0.0
        if self.gas.conducts():
            given, lost = heat.advance(self.gas, self.wall, self._geometry, self._heat, state, dt)
        if self.tau < math.inf:
            rubbed = rub(self._geometry, state, math.exp(-dt / self.tau))
        return given, lost, rubbed

    def _drag(self, state: np.ndarray, dt: float) -> None:
        """Viscosity for `dt`."""
        if self._viscous is not None:
            viscous_flow.advance(self.gas, self._viscosity, self._geometry, self._viscous, state, dt)

    def _flow_from(self, before: np.ndarray, after: np.ndarray, dt: float) -> None:
        """The hydrodynamic update."""
        flow = self._flow
        hancock.advance(
            self.gas, flow.limiter, flow.riemann, dt, flow.spacing_x, flow.spacing_y, flow.periodic,
            before, after, flow.scratch,
        )  # fmt: skip

    def memory(self) -> dict[str, np.ndarray]:
        """The wall temperature, first guess of the next solve for it."""
        return {"wall_temperature": self._heat.wall_temperature.copy()}

    def remember(self, memory: dict[str, np.ndarray]) -> None:
        """Take back what `memory` gave."""
        self._heat.wall_temperature[:] = memory["wall_temperature"]


def worth_threads(mesh: Mesh) -> int:
    """As many threads as numba may use, but not more than the mesh keeps busy."""
    nx, ny = mesh.cells
    return max(1, min(numba.get_num_threads(), nx * ny // CELLS_PER_THREAD, nx))


@contextlib.contextmanager
def thread_count(threads: int) -> Iterator[None]:
    """Use so many threads in kernels; a small mesh is faster without waking others."""
    before = numba.get_num_threads()
    numba.set_num_threads(threads)
    try:
        yield
    finally:
        numba.set_num_threads(before)


@kernel
def rub(geometry, state, keep):
    """Slow the flow to `keep` of its velocity by rolling friction; returns the energy that takes."""
    lost = 0.0
    for i in range(state.shape[1]):
        lost += geometry.dx[i] * rub_row(state[0, i], state[1, i], state[2, i], state[3, i], geometry.dy, keep)
    return lost


@part
def rub_row(density, momentum_x, momentum_y, energy, dy, keep):
    """Friction in one row of cells; returns the energy lost per width."""
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
def signal_rates(gas, state, dx, dy, work, rates):
    """Per row the largest rate at which signals cross half a cell, shape (nx,); infinite where n or T is out of bounds.

    Half a cell, because the update is unsplit, and because it is unstable beyond, in one direction already, without
    the acoustic dissipation of velocity jumps that Riemann solvers for low Mach numbers leave out.
    work: (nx, ny), overwritten.
    """
    for i in prange(state.shape[1]):
        signal_rate_row(gas, state[0, i], state[1, i], state[2, i], state[3, i], 1.0 / dx[i], dy, work[i])
        store_largest(work[i], rates, i)


@part
def signal_rate_row(gas, density, momentum_x, momentum_y, energy, over_dx, dy, rates):
    """Signal rates of one row of cells."""
    for j in range(np.uint64(density.size)):
        n = density[j]
        over = 1.0 / n
        u, v = abs(momentum_x[j] * over), abs(momentum_y[j] * over)
        T = energy[j] * over - 0.5 * (u * u + v * v)
        c = gas.sound_speed_at_pressure(n, gas.pressure(n, T))
        rate = 2.0 * max((u + c) * over_dx, (v + c) / dy[j])
        allowed = (n > 0.0) & (n < 1.0) & (T > 0.0) & (rate < np.inf)
        rates[j] = rate if allowed else np.inf
