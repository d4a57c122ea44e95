"""The explicit integrator: Strang splitting of the hydrodynamic update, heat and friction.

One step is half of (source, heat, friction), the whole hydrodynamic update, and the second half in reverse
order: second-order accurate. Friction is exact. A steady state leaves each part at rest by itself, hence is a
fixed point for every step size.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numba
import numpy as np
from numba import prange

from hydro.dynamics import hancock, heat
from hydro.dynamics.integrator import INTEGRATORS, Exchange, StepRejected
from hydro.dynamics.limiters import LIMITERS
from hydro.dynamics.riemann import RIEMANN_SOLVERS
from hydro.jit import kernel
from hydro.mesh import Mesh
from hydro.state import State, worst_cell

CELLS_PER_THREAD = 2048  # fewer are not worth waking a thread for

Source = Callable[[float, Mesh], np.ndarray]


class Flow(NamedTuple):
    """What the hydrodynamic update needs beside the states."""

    limiter: NamedTuple
    riemann: NamedTuple
    spacing_x: np.ndarray
    spacing_y: np.ndarray
    periodic: np.ndarray
    scratch: np.ndarray


@INTEGRATORS.register("godunov")
class Godunov:
    """Unsplit MUSCL-Hancock finite volumes with RKL2 conduction and cooling; see `hancock` and `heat`.

    `source(time, mesh)`, if given, is added to the equations: rates of the four conserved fields, shape
    (4, nx, ny), taken at mid-step. State and work space take 232 bytes per cell.
    """

    def __init__(
        self,
        gas,
        wall,
        mesh: Mesh,
        tau: float = math.inf,
        cfl: float = 0.8,
        limiter: str = "van_leer",
        riemann: str = "hllc_lm",
        source: Source | None = None,
    ):
        threads = worth_threads(mesh)
        self.gas, self.wall, self.mesh, self.tau, self.cfl, self.source = gas, wall, mesh, tau, cfl, source
        self._flow = Flow(
            LIMITERS[limiter], RIEMANN_SOLVERS[riemann], mesh.spacing(0), mesh.spacing(1), np.array(mesh.periodic),
            hancock.scratch_for(threads),
        )  # fmt: skip
        self._geometry = heat.Geometry.of(mesh)
        self._heat = heat.HeatArrays.of(mesh, threads)
        self._half, self._next = np.empty((4, *mesh.cells)), np.empty((4, *mesh.cells))
        self._rates = np.empty(mesh.cells[0])

    def largest_step(self, state: State) -> float:
        """cfl over the largest (|u|+c)/dx + (|v|+c)/dy; zero for an inadmissible state."""
        signal_rates(self.gas, state.conserved, self.mesh.dx, self.mesh.dy, self._rates)
        return self.cfl / self._rates.max()

    def step(self, state: State, dt: float) -> Exchange:
        """Advance `state` in place by `dt`; StepRejected, if n or T would leave its bounds, leaves it untouched."""
        guess = self._heat.wall_temperature.copy()
        source = np.empty((4, 0, 0)) if self.source is None else self.source(state.time + 0.5 * dt, self.mesh)
        wall, collisions, friction = strang_step(
            self.gas, self.wall, self.tau, self._flow, self._geometry, self._heat, source,
            dt, state.conserved, self._half, self._next,
        )  # fmt: skip
        signal_rates(self.gas, self._next, self.mesh.dx, self.mesh.dy, self._rates)
        if not self._rates.max() < math.inf:
            self._heat.wall_temperature[:] = guess
            raise StepRejected(worst_cell(State(self.gas, self.mesh, self._next)))
        state.conserved, self._next = self._next, state.conserved
        state.time += dt
        given = dt * self.mesh.integral(source[3]) if source.size else 0.0
        return Exchange(wall, collisions, friction, given)

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


@kernel
def strang_step(gas, wall, tau, flow, geometry, arrays, source, dt, old, half, new):
    """One step from `old` into `new`; returns the energies given by the wall, lost in collisions and by friction."""
    half[:] = old
    if source.size:
        half += 0.5 * dt * source
    given, lost = heat_if_any(gas, wall, geometry, arrays, half, 0.5 * dt)
    rubbed = rub_if_any(tau, geometry, half, 0.5 * dt)
    hancock.advance(
        gas, flow.limiter, flow.riemann, dt, flow.spacing_x, flow.spacing_y, flow.periodic, half, new, flow.scratch
    )
    rubbed += rub_if_any(tau, geometry, new, 0.5 * dt)
    given_later, lost_later = heat_if_any(gas, wall, geometry, arrays, new, 0.5 * dt)
    if source.size:
        new += 0.5 * dt * source
    return given + given_later, lost + lost_later, rubbed


@kernel
def heat_if_any(gas, wall, geometry, arrays, state, dt):
    """Conduction, cooling and wall heat; none without K."""
    return heat.advance(gas, wall, geometry, arrays, state, dt) if gas.K > 0.0 else (0.0, 0.0)


@kernel
def rub_if_any(tau, geometry, state, dt):
    """Slow the flow by rolling friction, exactly; returns the energy that takes."""
    if tau == np.inf:
        return 0.0
    keep = np.exp(-dt / tau)
    lost = np.empty(state.shape[1])
    for i in range(state.shape[1]):
        lost[i] = geometry.dx[i] * rub_row(state[0, i], state[1, i], state[2, i], state[3, i], geometry.dy, keep)
    return lost.sum()


@kernel
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
def signal_rates(gas, state, dx, dy, rates):
    """Per row the largest (|u|+c)/dx + (|v|+c)/dy, shape (nx,); infinite where n or T is out of bounds."""
    for i in prange(state.shape[1]):
        signal_rate_row(gas, state[0, i], state[1, i], state[2, i], state[3, i], dx[i], dy, rates, i)


@kernel
def signal_rate_row(gas, density, momentum_x, momentum_y, energy, dx, dy, rates, i):
    """Row i of `signal_rates`."""
    largest = 0.0
    for j in range(np.uint64(density.size)):
        n = density[j]
        over = 1.0 / n
        u, v = abs(momentum_x[j] * over), abs(momentum_y[j] * over)
        T = energy[j] * over - 0.5 * (u * u + v * v)
        c = gas.sound_speed_at_pressure(n, gas.pressure(n, T))
        rate = (u + c) / dx + (v + c) / dy[j]
        allowed = n > 0.0 and n < 1.0 and T > 0.0 and rate < np.inf
        rate = rate if allowed else np.inf
        largest = rate if rate > largest else largest
    rates[i] = largest
