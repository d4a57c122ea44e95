"""The implicit integrator: an implicit Lagrange stage and a MUSCL remap, taken together.

In a Lagrange stage the faces move with the velocity that the new pressure gives them; the remap carries what the faces
have swept over (density, momentum and enthalpy, with limited slopes) from cell to cell. Doing one after the other
splits what balances in a slow flow, and is first order in time. Here both are parts of one conservative update

    (y_new - y_base)/h = H(y_ahead, y_new):

velocities of the faces, pressure, conduction, cooling, the wall's heat and friction are those of the new state; the
swept profiles are those of `y_ahead`, extrapolated in time from the last two states. With the weights of the variable
second-order backward difference (BDF2; Hundsdorfer and Verwer, 2003, IV.4) it is second order, and as stiff a method
as backward Euler: sound that is not resolved dies. Steps are limited by the remap (no face crosses more than a share
`cfl` of a cell) and by the change that the extrapolation does not foresee (`tolerance`).

The unknowns are pressure and temperature of every cell; density follows from them and stays in (0, 1). Newton's
equations, five points with two unknowns each, are solved by one multigrid cycle per iteration (see `multigrid`) under
exact residuals. The last update is in flux form, so that mass and the books of energy do not depend on how well.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from hydro.dynamics import multigrid
from hydro.dynamics.heat import Geometry
from hydro.dynamics.integrator import INTEGRATORS, Exchange, StepRejected
from hydro.dynamics.limiters import LIMITERS
from hydro.gas import Closure
from hydro.jit import inline, kernel, part
from hydro.mesh import GHOSTS, Mesh
from hydro.state import State, worst_cell

TOLERANCE = 1e-3  # when a deck gives none
LONGER, SHORTER = 1.5, 0.3  # limits of a change of the step
SAFETY = 0.9
REJECTED = 2.0  # times the tolerance
SOLVED = 1e-8  # largest relative change of pressure and temperature in the last iteration
ITERATIONS = 40
FIRST_STEP = 0.1  # of the time in which sound crosses a cell

N, MX, MY, E = 0, 1, 2, 3
FLOW, ENERGY = 0, 1  # rows of `carried`: mass, and energy, that a unit of momentum at the face takes along
HEAT_IN, LOST, RUBBED = 0, 1, 2  # rows of `totals`


class Work(NamedTuple):
    """Arrays of one step; cells (nx, ny), faces [i, j] below cell [i, j]."""

    ahead: np.ndarray  # (4, nx, ny), extrapolated n, u, v, p
    base: np.ndarray  # (4, nx, ny), what the last two states contribute
    momentum: np.ndarray  # (2, nx, ny), of cells, before pressure acts
    carried_x: np.ndarray  # (2, nx, ny)
    carried_y: np.ndarray
    drive_x: np.ndarray  # (nx, ny), momentum of faces, before pressure acts
    drive_y: np.ndarray
    density: np.ndarray  # (nx, ny)
    kappa: np.ndarray
    wall_flux: np.ndarray  # (ny,)
    wall_temperature: np.ndarray  # (ny,)


class Grid(NamedTuple):
    """The mesh as the kernels see it."""

    heat: Geometry
    spacing_x: np.ndarray
    spacing_y: np.ndarray


@INTEGRATORS.register("lagrange-remap")
class LagrangeRemap:
    """Semi-implicit Lagrange-remap finite volumes, second order in time and space.

    cfl: largest share of a cell that a face may sweep in a step. tolerance: largest root mean square change, relative,
    of density and pressure (and of the velocity, against sound) that the last two states do not foresee.
    """

    def __init__(
        self,
        gas: Closure,
        wall: Any,
        mesh: Mesh,
        tau: float = math.inf,
        cfl: float = 0.5,
        limiter: str = "van_leer",
        tolerance: float = TOLERANCE,
    ):
        nx, ny = mesh.cells
        self.gas, self.wall, self.mesh, self.tau, self.cfl, self.tolerance = gas, wall, mesh, tau, cfl, tolerance
        self.limiter = LIMITERS[limiter]
        self._grid = Grid(Geometry.of(mesh), mesh.spacing(0), mesh.spacing(1))
        self._work = Work(
            np.zeros((4, nx, ny)), np.zeros((4, nx, ny)), np.zeros((2, nx, ny)), np.zeros((2, nx, ny)),
            np.zeros((2, nx, ny)), np.zeros((nx, ny)), np.zeros((nx, ny)), np.zeros((nx, ny)),
            np.zeros((nx, ny)), np.zeros(ny), np.zeros(ny),
        )  # fmt: skip
        self._hierarchy = multigrid.Hierarchy(mesh)
        self._last = np.zeros((4, nx, ny))  # the state before
        self._velocity = np.zeros((2, 2, nx, ny))  # of faces in x and in y: now, and before
        self._next = np.zeros((4, nx, ny))
        self._unknowns = np.zeros((2, nx, ny))  # pressure, temperature
        self._steps = np.zeros(
            2
        )  # the last step, and the largest that the error allows for the next; zero at the start
        self._exchange = np.zeros(4)  # in the last step
        self.iterations = 0

    def largest_step(self, state: State) -> float:
        """What the remap, the error, and the last step allow."""
        last, allowed = self._steps
        if last == 0.0:
            c = self.gas.sound_speed(state.density, state.temperature)
            width = np.minimum(self.mesh.dx[:, None], self.mesh.dy[None, :])
            return FIRST_STEP * float(np.min(width / (c + state.speed)))
        swept = sweep_rate(self._velocity[0], self.mesh.dx, self.mesh.dy)
        return min(allowed, self.cfl / swept if swept > 0.0 else math.inf)

    def step(self, state: State, dt: float) -> Exchange:
        """Advance `state` in place by `dt`; StepRejected leaves it untouched."""
        ratio = dt / self._steps[0] if self._steps[0] > 0.0 else 0.0
        if ratio == 0.0:
            face_velocities(self._grid.heat, state.conserved, self._velocity[0])
        admissible = self._look_ahead(state.conserved, ratio)
        if not admissible:
            ratio = 0.0
            if not self._look_ahead(state.conserved, ratio):
                raise StepRejected(worst_cell(state))
        h = dt * (1.0 + ratio) / (1.0 + 2.0 * ratio)
        work, friction = self._work, 1.0 / self.tau
        advected = self._velocity[0] + ratio * (self._velocity[0] - self._velocity[1])
        carry(self.gas, self.limiter, self._grid, advected, h, work)
        self._solve(h, friction)
        P, T = self._unknowns
        totals = finish(self.gas, self.wall, self._grid, P, T, h, friction, work, self._next, advected)
        error = unforeseen(self.gas, self.mesh.areas, self._next, work.ahead)
        self._judge(error, dt, State(self.gas, self.mesh, self._next))
        self._last[:] = state.conserved
        self._velocity[1] = self._velocity[0]
        self._velocity[0] = advected
        state.conserved[:] = self._next
        state.time += dt
        return self._book(totals, ratio, h)

    def _look_ahead(self, now: np.ndarray, ratio: float) -> bool:
        """Extrapolate; whether n and T stay in their bounds."""
        return look_ahead(self.gas, now, self._last, ratio, self._work.ahead, self._work.base)

    def _solve(self, h: float, friction: float) -> None:
        """Pressure and temperature of the new state."""
        work, finest = self._work, self._hierarchy.levels[0]
        P, T = self._unknowns
        P[:] = work.ahead[3]
        T[:] = self.gas.temperature(work.ahead[0], P)
        change = math.inf
        for iteration in range(ITERATIONS):
            balance(self.gas, self.wall, self._grid, P, T, h, friction, work, finest.right)
            if iteration == 0:
                couple(self.gas, self._grid, P, T, h, friction, work, finest.local, finest.faces_x, finest.faces_y)
                self._couple_wall(P[-1], T[-1], h, finest)
                self._hierarchy.prepare()
            self._hierarchy.cycle()
            change = correct(finest.unknowns, P, T)
            self.iterations += 1
            if change < SOLVED:
                return
        raise StepRejected(f"the implicit stage does not converge: last change {change:.2g}")

    def _couple_wall(self, P: np.ndarray, T: np.ndarray, h: float, finest: multigrid.Level) -> None:
        """The derivative of the wall's heat, into the local terms of the last row of cells."""
        if self._grid.heat.periodic_x:
            return
        n, half_width = self.gas.density(P, T), 0.5 * self.mesh.dx[-1]
        in_n, in_T = self.wall.face_slopes(self.gas, n, T, half_width, self._work.wall_temperature)
        p_n, p_T = self.gas.pressure_slopes(n, T)
        finest.local[2, -1] -= h * self.mesh.dy * in_n / p_n
        finest.local[3, -1] -= h * self.mesh.dy * (in_T - in_n * p_T / p_n)

    def _judge(self, error: float, dt: float, trial: State) -> None:
        """Choose the next step; StepRejected if this one changed more than foreseen, or left the bounds."""
        if not error < math.inf:
            raise StepRejected(worst_cell(trial))
        factor = SAFETY * math.sqrt(self.tolerance / max(error, 1e-300))
        if error > REJECTED * self.tolerance and self._steps[0] > 0.0:
            raise StepRejected(f"the change not foreseen is {error:.2g}, the tolerance {self.tolerance:.2g}")
        self._steps[:] = dt, dt * min(max(factor, SHORTER), LONGER)

    def _book(self, totals: np.ndarray, ratio: float, h: float) -> Exchange:
        """Energies exchanged: the backward difference passes a share of the last step's on."""
        share = ratio**2 / (1.0 + 2.0 * ratio)
        self._exchange *= share
        self._exchange[:3] += h * totals
        return Exchange(*self._exchange.tolist())

    def memory(self) -> dict[str, np.ndarray]:
        """The state before, velocities of the faces, steps, the last exchange, and the wall's temperature."""
        kept = {
            "last": self._last, "velocity": self._velocity, "steps": self._steps, "exchange": self._exchange,
            "wall_temperature": self._work.wall_temperature,
        }  # fmt: skip
        return {name: values.copy() for name, values in kept.items()}

    def remember(self, memory: dict[str, np.ndarray]) -> None:
        """Take back what `memory` gave."""
        self._last[:], self._velocity[:] = memory["last"], memory["velocity"]
        self._steps[:], self._exchange[:] = memory["steps"], memory["exchange"]
        self._work.wall_temperature[:] = memory["wall_temperature"]


@kernel
def sweep_rate(velocity, dx, dy):
    """The largest share of a cell that a face sweeps per time; velocity: (2, nx, ny) of faces in x and in y."""
    largest = 0.0
    for i in range(dx.size):
        for j in range(dy.size):
            in_x = abs(velocity[0, i, j]) / min(dx[i], dx[i - 1])
            in_y = abs(velocity[1, i, j]) / min(dy[j], dy[j - 1])
            largest = max(largest, in_x, in_y)
    return largest


@kernel
def face_velocities(geometry, state, velocity):
    """Mean velocities of the two cells of every face; zero at walls."""
    for i in range(state.shape[1]):
        for j in range(state.shape[2]):
            n, low, left = state[N, i, j], state[N, i - 1, j], state[N, i, j - 1]
            open_x, open_y = i > 0 or geometry.periodic_x, j > 0 or geometry.periodic_y
            velocity[0, i, j] = (state[MX, i, j] + state[MX, i - 1, j]) / (n + low) if open_x else 0.0
            velocity[1, i, j] = (state[MY, i, j] + state[MY, i, j - 1]) / (n + left) if open_y else 0.0


@kernel
def look_ahead(gas, now, last, ratio, ahead, base):
    """Extrapolated n, u, v, p and the contribution of both states; False where n or T would leave its bounds."""
    weight = ratio * ratio / (1.0 + 2.0 * ratio)
    good = True
    for i in range(now.shape[1]):
        for j in range(now.shape[2]):
            for q in range(4):
                base[q, i, j] = now[q, i, j] + weight * (now[q, i, j] - last[q, i, j])
            n = now[N, i, j] + ratio * (now[N, i, j] - last[N, i, j])
            u = (now[MX, i, j] + ratio * (now[MX, i, j] - last[MX, i, j])) / n
            v = (now[MY, i, j] + ratio * (now[MY, i, j] - last[MY, i, j])) / n
            e = now[E, i, j] + ratio * (now[E, i, j] - last[E, i, j])
            T = e / n - 0.5 * (u * u + v * v)
            good = good and n > 0.0 and n < 1.0 and T > 0.0
            ahead[0, i, j], ahead[1, i, j], ahead[2, i, j], ahead[3, i, j] = n, u, v, gas.pressure(n, T)
    return good


@kernel
def carry(gas, limiter, grid, velocity, h, work):
    """Swept profiles at the faces, and momentum of cells and faces before pressure acts.

    velocity: of the faces, (2, nx, ny).
    """
    geometry, ahead = grid.heat, work.ahead
    nx, ny = ahead.shape[1:]
    for i in range(nx):
        for j in range(ny):
            work.momentum[0, i, j], work.momentum[1, i, j] = work.base[MX, i, j], work.base[MY, i, j]
    for i in range(nx):
        for j in range(ny):
            if i > 0 or geometry.periodic_x:
                sweep(
                    gas,
                    limiter,
                    ahead,
                    velocity[0, i, j],
                    (i - 2) % nx,
                    i - 1,
                    i,
                    (i + 1) % nx,
                    j,
                    j,
                    j,
                    j,
                    grid.spacing_x,
                    i,
                    i <= 1 and not geometry.periodic_x,
                    i == nx - 1 and not geometry.periodic_x,
                    geometry.dy[j],
                    h / geometry.dx[i - 1],
                    h / geometry.dx[i],
                    work.carried_x,
                    work.momentum,
                    i,
                    j,
                )
            if j > 0 or geometry.periodic_y:
                sweep(
                    gas,
                    limiter,
                    ahead,
                    velocity[1, i, j],
                    i,
                    i,
                    i,
                    i,
                    (j - 2) % ny,
                    j - 1,
                    j,
                    (j + 1) % ny,
                    grid.spacing_y,
                    j,
                    j <= 1 and not geometry.periodic_y,
                    j == ny - 1 and not geometry.periodic_y,
                    geometry.dx[i],
                    h / geometry.dy[j - 1],
                    h / geometry.dy[j],
                    work.carried_y,
                    work.momentum,
                    i,
                    j,
                )
    for i in range(nx):
        for j in range(ny):
            work.drive_x[i, j] = 0.5 * (work.momentum[0, i, j] + work.momentum[0, i - 1, j])
            work.drive_y[i, j] = 0.5 * (work.momentum[1, i, j] + work.momentum[1, i, j - 1])


@part
def sweep(gas, limiter, ahead, speed, i0, i1, i2, i3, j0, j1, j2, j3, spacing, k, at_low, at_high, length,
          share_low, share_high, carried, momentum, i, j):  # fmt: skip
    """One face, between cells 1 and 2 of a line of four; k is the number of cell 2 along the line."""
    centre = k + GHOSTS
    n, u, v, p = 0.0, 0.0, 0.0, 0.0
    if speed >= 0.0:  # from the lower side; where nothing moves, from both: mirror images have to stay so
        weight = 1.0 if speed > 0.0 else 0.5
        low, high = spacing[1, centre - 1], spacing[2, centre - 1]
        n += weight * profile(limiter, ahead[0], i0, j0, i1, j1, i2, j2, low, high, at_low, False, 0.5)
        u += weight * profile(limiter, ahead[1], i0, j0, i1, j1, i2, j2, low, high, at_low, False, 0.5)
        v += weight * profile(limiter, ahead[2], i0, j0, i1, j1, i2, j2, low, high, at_low, False, 0.5)
        p += weight * profile(limiter, ahead[3], i0, j0, i1, j1, i2, j2, low, high, at_low, False, 0.5)
    if speed <= 0.0:
        weight = 1.0 if speed < 0.0 else 0.5
        low, high = spacing[1, centre], spacing[2, centre]
        n += weight * profile(limiter, ahead[0], i1, j1, i2, j2, i3, j3, low, high, False, at_high, -0.5)
        u += weight * profile(limiter, ahead[1], i1, j1, i2, j2, i3, j3, low, high, False, at_high, -0.5)
        v += weight * profile(limiter, ahead[2], i1, j1, i2, j2, i3, j3, low, high, False, at_high, -0.5)
        p += weight * profile(limiter, ahead[3], i1, j1, i2, j2, i3, j3, low, high, False, at_high, -0.5)
    density = 0.5 * (ahead[0, i1, j1] + ahead[0, i2, j2])
    enthalpy = p / gas.compressibility(n) + p + 0.5 * n * (u * u + v * v)
    carried[FLOW, i, j] = length * n / density
    carried[ENERGY, i, j] = length * enthalpy / density
    flow = n * speed
    momentum[0, i1, j1] -= share_low * flow * u
    momentum[0, i2, j2] += share_high * flow * u
    momentum[1, i1, j1] -= share_low * flow * v
    momentum[1, i2, j2] += share_high * flow * v


@inline
def profile(limiter, field, i0, j0, i1, j1, i2, j2, low, high, at_low, at_high, place):
    """Limited linear profile of cell 1 at `place` widths from its centre; zero slope beside a wall."""
    here = field[i1, j1]
    below = 0.0 if at_low else (here - field[i0, j0]) * low
    above = 0.0 if at_high else (field[i2, j2] - here) * high
    return here + place * limiter.limited(below, above)


@inline
def pushed(drive, low, high, inverse, h, slow):
    """Momentum of a face after pressure and friction have acted."""
    return slow * (drive - h * (high - low) * inverse)


@part
def density_and_conductivity(gas, P, T, work):
    """Closures of all cells for the unknowns."""
    for i in range(P.shape[0]):
        for j in range(P.shape[1]):
            n = gas.density(P[i, j], T[i, j])
            work.density[i, j] = n
            work.kappa[i, j] = gas.conductivity(n, T[i, j])


@part
def heat_wall(gas, wall, geometry, T, work):
    """Heat flux from the driving wall."""
    if geometry.periodic_x:
        return
    last = T.shape[0] - 1
    for j in range(T.shape[1]):
        here = T[last, j]
        guess = work.wall_temperature[j] if work.wall_temperature[j] > 0.0 else here
        work.wall_flux[j], work.wall_temperature[j] = wall.face(
            gas, work.density[last, j], here, 0.5 * geometry.dx[last], guess
        )


@part
def outflow(geometry, P, T, h, slow, work, i, j):
    """(mass, energy) flowing out of a cell and heat flowing in, per time, the driving wall's included."""
    nx, ny = P.shape
    k, m = (i + 1) % nx, (j + 1) % ny
    low, left = i - 1, j - 1
    into_x = pushed(work.drive_x[i, j], P[low, j], P[i, j], geometry.inverse_x[i], h, slow)
    from_x = pushed(work.drive_x[k, j], P[i, j], P[k, j], geometry.inverse_x[i + 1], h, slow)
    into_y = pushed(work.drive_y[i, j], P[i, left], P[i, j], geometry.inverse_y[j], h, slow)
    from_y = pushed(work.drive_y[i, m], P[i, j], P[i, m], geometry.inverse_y[j + 1], h, slow)
    carried_x, carried_y, kappa = work.carried_x, work.carried_y, work.kappa
    mass_x = carried_x[FLOW, k, j] * from_x - carried_x[FLOW, i, j] * into_x
    mass_y = carried_y[FLOW, i, m] * from_y - carried_y[FLOW, i, j] * into_y
    energy_x = carried_x[ENERGY, k, j] * from_x - carried_x[ENERGY, i, j] * into_x
    energy_y = carried_y[ENERGY, i, m] * from_y - carried_y[ENERGY, i, j] * into_y
    below = 0.5 * geometry.inverse_x[i] * (kappa[low, j] + kappa[i, j]) * (T[i, j] - T[low, j])
    above = 0.5 * geometry.inverse_x[i + 1] * (kappa[i, j] + kappa[k, j]) * (T[k, j] - T[i, j])
    if not geometry.periodic_x:
        below = 0.0 if i == 0 else below
        above = work.wall_flux[j] if i == nx - 1 else above
    before = 0.5 * geometry.inverse_y[j] * (kappa[i, left] + kappa[i, j]) * (T[i, j] - T[i, left])
    behind = 0.5 * geometry.inverse_y[j + 1] * (kappa[i, j] + kappa[i, m]) * (T[i, m] - T[i, j])
    if not geometry.periodic_y:
        before = 0.0 if j == 0 else before
        behind = 0.0 if j == ny - 1 else behind
    heat = geometry.dy[j] * (above - below) + geometry.dx[i] * (behind - before)
    return mass_x + mass_y, energy_x + energy_y, heat


@part
def pushed_cell(geometry, P, h, slow, work, i, j):
    """Momentum of a cell after the pressures on its faces and friction have acted."""
    nx, ny = P.shape
    here = P[i, j]
    low = here if i == 0 and not geometry.periodic_x else 0.5 * (P[i - 1, j] + here)
    high = here if i == nx - 1 and not geometry.periodic_x else 0.5 * (P[(i + 1) % nx, j] + here)
    left = here if j == 0 and not geometry.periodic_y else 0.5 * (P[i, j - 1] + here)
    right = here if j == ny - 1 and not geometry.periodic_y else 0.5 * (P[i, (j + 1) % ny] + here)
    in_x = slow * (work.momentum[0, i, j] - h * (high - low) / geometry.dx[i])
    in_y = slow * (work.momentum[1, i, j] - h * (right - left) / geometry.dy[j])
    return in_x, in_y


@kernel
def balance(gas, wall, grid, P, T, h, friction, work, right):
    """What is missing in the balances of mass and energy of every cell, into `right` (2, nx, ny)."""
    geometry, slow = grid.heat, 1.0 / (1.0 + h * friction)
    density_and_conductivity(gas, P, T, work)
    heat_wall(gas, wall, geometry, T, work)
    for i in range(P.shape[0]):
        for j in range(P.shape[1]):
            area, n, here = geometry.dx[i] * geometry.dy[j], work.density[i, j], T[i, j]
            mass, energy, heat = outflow(geometry, P, T, h, slow, work, i, j)
            in_x, in_y = pushed_cell(geometry, P, h, slow, work, i, j)
            kinetic = 0.5 * (in_x * in_x + in_y * in_y) / n
            lost = gas.cooling(n, here) + 2.0 * friction * kinetic
            right[0, i, j] = area * (work.base[N, i, j] - n) - h * mass
            stored = n * here + kinetic - work.base[E, i, j]
            right[1, i, j] = h * (heat - energy) - area * (stored + h * lost)


@kernel
def couple(gas, grid, P, T, h, friction, work, local, faces_x, faces_y):
    """Derivatives of the balances: local terms and couplings across faces, for `multigrid`."""
    geometry, slow = grid.heat, 1.0 / (1.0 + h * friction)
    push = h * h * slow
    for i in range(P.shape[0]):
        for j in range(P.shape[1]):
            area, n, here = geometry.dx[i] * geometry.dy[j], work.density[i, j], T[i, j]
            n_P, n_T = density_slopes(gas, n, here)
            i_n, i_T = gas.cooling_slopes(n, here)
            local[0, i, j], local[1, i, j] = area * n_P, area * n_T
            local[2, i, j] = area * (n_P * here + h * i_n * n_P)
            local[3, i, j] = area * (n + n_T * here + h * (i_n * n_T + i_T))
            in_x, in_y = geometry.inverse_x[i], geometry.inverse_y[j]
            if i > 0 or geometry.periodic_x:
                conductance = h * geometry.dy[j] * in_x
                couple_face(gas, work, T, i - 1, j, i, j, push * in_x, work.carried_x, conductance, faces_x)
            if j > 0 or geometry.periodic_y:
                conductance = h * geometry.dx[i] * in_y
                couple_face(gas, work, T, i, j - 1, i, j, push * in_y, work.carried_y, conductance, faces_y)


@inline
def density_slopes(gas, n, T):
    """(dn/dP at fixed T, dn/dT at fixed P)."""
    p_n, p_T = gas.pressure_slopes(n, T)
    return 1.0 / p_n, -p_T / p_n


@part
def couple_face(gas, work, T, i0, j0, i, j, push, carried, conductance, faces):
    """The couplings across one face, from cell (i0, j0) to cell (i, j)."""
    faces[multigrid.MASS, i, j] = push * carried[FLOW, i, j]
    faces[multigrid.ENERGY_P, i, j] = push * carried[ENERGY, i, j]
    faces[multigrid.ENERGY_T, i, j] = 0.5 * conductance * (work.kappa[i0, j0] + work.kappa[i, j])
    lever = 0.5 * conductance * (T[i, j] - T[i0, j0])
    below_P, below_T = conductivity_slopes(gas, work.density[i0, j0], T[i0, j0])
    above_P, above_T = conductivity_slopes(gas, work.density[i, j], T[i, j])
    faces[multigrid.DRIFT_PA, i, j], faces[multigrid.DRIFT_PB, i, j] = lever * below_P, lever * above_P
    faces[multigrid.DRIFT_TA, i, j], faces[multigrid.DRIFT_TB, i, j] = lever * below_T, lever * above_T


@inline
def conductivity_slopes(gas, n, T):
    """(d kappa/dP at fixed T, d kappa/dT at fixed P)."""
    n_P, n_T = density_slopes(gas, n, T)
    k_n, k_T = gas.conductivity_slopes(n, T)
    return k_n * n_P, k_T + k_n * n_T


@kernel
def correct(change, P, T):
    """Add the change (2, nx, ny + 2) to the unknowns, none by more than half; returns the largest relative change."""
    largest = 0.0
    for i in range(P.shape[0]):
        for j in range(P.shape[1]):
            size = max(abs(change[0, i, j + 1] / P[i, j]), abs(change[1, i, j + 1] / T[i, j]))
            largest = largest if size <= largest else size
    share = min(1.0, 0.5 / largest) if largest > 0.0 else 1.0
    for i in range(P.shape[0]):
        for j in range(P.shape[1]):
            P[i, j] += share * change[0, i, j + 1]
            T[i, j] += share * change[1, i, j + 1]
    return largest


@kernel
def finish(gas, wall, grid, P, T, h, friction, work, state, velocity):
    """The new state (4, nx, ny) in flux form and the velocities of the faces (2, nx, ny).

    Returns powers: given by the wall, lost in collisions, lost by friction.
    """
    geometry, slow = grid.heat, 1.0 / (1.0 + h * friction)
    density_and_conductivity(gas, P, T, work)
    heat_wall(gas, wall, geometry, T, work)
    totals = np.zeros(3)
    for i in range(P.shape[0]):
        for j in range(P.shape[1]):
            area = geometry.dx[i] * geometry.dy[j]
            mass, energy, heat = outflow(geometry, P, T, h, slow, work, i, j)
            in_x, in_y = pushed_cell(geometry, P, h, slow, work, i, j)
            cooled = gas.cooling(work.density[i, j], T[i, j])
            rubbed = friction * (in_x * in_x + in_y * in_y) / work.density[i, j]
            state[N, i, j] = work.base[N, i, j] - h * mass / area
            state[MX, i, j], state[MY, i, j] = in_x, in_y
            state[E, i, j] = work.base[E, i, j] + h * ((heat - energy) / area - cooled - rubbed)
            totals[LOST] += area * cooled
            totals[RUBBED] += area * rubbed
            n, low, left = work.ahead[0, i, j], work.ahead[0, i - 1, j], work.ahead[0, i, j - 1]
            along_x = pushed(work.drive_x[i, j], P[i - 1, j], P[i, j], geometry.inverse_x[i], h, slow)
            along_y = pushed(work.drive_y[i, j], P[i, j - 1], P[i, j], geometry.inverse_y[j], h, slow)
            velocity[0, i, j] = 2.0 * along_x / (n + low) if i > 0 or geometry.periodic_x else 0.0
            velocity[1, i, j] = 2.0 * along_y / (n + left) if j > 0 or geometry.periodic_y else 0.0
    if not geometry.periodic_x:
        for j in range(P.shape[1]):
            totals[HEAT_IN] += work.wall_flux[j] * geometry.dy[j]
    return totals


@kernel
def unforeseen(gas, areas, state, ahead):
    """Root mean square, over the box, of what the extrapolation `ahead` (n, u, v, p) missed; infinite out of bounds.

    Density and pressure relative, velocity against sound.
    """
    total, area = 0.0, 0.0
    for i in range(areas.shape[0]):
        for j in range(areas.shape[1]):
            n = state[N, i, j]
            u, v = state[MX, i, j] / n, state[MY, i, j] / n
            T = state[E, i, j] / n - 0.5 * (u * u + v * v)
            if not (n > 0.0 and n < 1.0 and T > 0.0):
                return np.inf
            p = gas.pressure(n, T)
            c = gas.sound_speed_at_pressure(n, p)
            in_n, in_p = ahead[0, i, j] / n - 1.0, ahead[3, i, j] / p - 1.0
            in_u, in_v = (ahead[1, i, j] - u) / c, (ahead[2, i, j] - v) / c
            total += areas[i, j] * (in_n * in_n + in_p * in_p + in_u * in_u + in_v * in_v)
            area += areas[i, j]
    return np.sqrt(total / area)
