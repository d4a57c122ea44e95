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

Viscosity is implicit, too, in velocities that are found before the pressure is (see `viscosity`).

Momentum lives on the faces, each component on those that it points through; that of a cell is the mean of its faces.
The unknowns are pressure and temperature of every cell; density follows from them and stays in (0, 1). Newton's
equations, five points with two unknowns each, are solved by one multigrid cycle per iteration (see `multigrid`) under
exact residuals. What the iteration leaves of the sums over the box is made up for, so that mass and the books of energy
do not depend on how well it converged. (A last update in flux form would do so cell by cell, but multiplies the errors
of short waves by h kappa/dx^2, a thousand or more, every step.)

Kernels in which cells meet their neighbours are exact: those above and below count alike to the last bit, and a start
that is its own mirror image in y stays so. Only sums over the box are not.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from hydro.dynamics import multigrid
from hydro.dynamics import viscosity as viscous_flow
from hydro.dynamics.integrator import INTEGRATORS, Exchange, Integrator, Source, StepRejected
from hydro.dynamics.limiters import LIMITERS
from hydro.dynamics.viscosity import SHARE
from hydro.gas import Closure
from hydro.jit import kernel, part
from hydro.mesh import GHOSTS, Geometry, Mesh
from hydro.state import State, worst_cell

TOLERANCE = 3e-4  # when a deck gives none
LONGER, SHORTER = 1.5, 0.3  # limits of a change of the step
SAFETY = 0.9
REJECTED = 2.0  # times the tolerance
SOLVED = 1e-10  # largest relative error of pressure and temperature, by changes and contraction; or SHARE of the first
SLOWEST = 0.99  # contraction of the iteration that this estimate reckons with; it takes the slowest in a step
ITERATIONS = 40
FIRST_STEP = 0.1  # of the time in which sound crosses a cell

N, MX, MY, E = 0, 1, 2, 3
FLOW, ENERGY = 0, 1  # rows of `carried`: mass, and energy, that a unit of momentum at the face takes along
HEAT_IN, LOST, RUBBED = 0, 1, 2  # entries of `totals`

# Scratch lines. Of faces: momentum, mass, energy and heat; in x below or above the rows that have an even number, and
# those that have an odd one, and in y.
EVEN, ODD, ALONG = 0, 4, 8
PUSHED = 12  # momentum of cells in x and y
WEIGHT, PROFILES, STREAMS, DENSITY_LOW, DENSITY_HIGH, PADDED = 14, 15, 19, 21, 22, 23
LINES = 24
ZERO, ONE, TWO = np.uint64(0), np.uint64(1), np.uint64(2)


class Work(NamedTuple):
    """Arrays of one step; cells (nx, ny), faces [i, j] below cell [i, j]."""

    ahead: np.ndarray  # (4, nx, ny), extrapolated n, u, v, p
    base: np.ndarray  # (4, nx, ny), what the last two states contribute
    stream: np.ndarray  # (2, nx, ny), change of the momentum of cells by what streams in and out
    carried_x: np.ndarray  # (2, nx, ny)
    carried_y: np.ndarray
    drive_x: np.ndarray  # (nx, ny), momentum of faces, before pressure acts
    drive_y: np.ndarray
    density: np.ndarray  # (nx, ny)
    kappa: np.ndarray
    cooling: np.ndarray
    kappa_slopes: np.ndarray  # (2, nx, ny), in P and in T
    lines: np.ndarray  # (LINES, ny + 4), scratch
    wall_flux: np.ndarray  # (ny,)
    wall_temperature: np.ndarray  # (ny,)


class Grid(NamedTuple):
    """The mesh as the kernels see it."""

    heat: Geometry
    spacing_x: np.ndarray
    spacing_y: np.ndarray


@INTEGRATORS.register("lagrange-remap")
class LagrangeRemap(Integrator):
    """Semi-implicit Lagrange-remap finite volumes, second order in time and space.

    cfl: largest share of a cell that a face may sweep in a step. tolerance: largest root mean square change, relative,
    of density and pressure (and of the velocity, against sound) that the last two states do not foresee.
    `source(time, mesh)`, if given, is added to the equations: rates of the four conserved fields, shape (4, nx, ny),
    taken at the new time. viscosity: of the gas, over that of the closure. State and work space take 590 bytes per
    cell, 208 more with viscosity. ValueError for a mesh of a single cell in a direction.
    """

    def __init__(
        self,
        gas: Closure,
        wall: Any,
        mesh: Mesh,
        tau: float = math.inf,
        cfl: float = 0.8,
        limiter: str = "van_leer",
        tolerance: float = TOLERANCE,
        source: Source | None = None,
        viscosity: float = 0.0,
    ):
        nx, ny = mesh.cells
        if min(mesh.cells) < 2:
            raise ValueError(f"{mesh.cells} cells: two or more are needed in both directions")
        self.gas, self.wall, self.mesh, self.tau, self.cfl, self.tolerance = gas, wall, mesh, tau, cfl, tolerance
        self.limiter, self.source = LIMITERS[limiter], source
        self._grid = Grid(Geometry.of(mesh), mesh.spacing(0), mesh.spacing(1))
        self._work = Work(
            np.zeros((4, nx, ny)), np.zeros((4, nx, ny)), np.zeros((2, nx, ny)), np.zeros((2, nx, ny)),
            np.zeros((2, nx, ny)), np.zeros((nx, ny)), np.zeros((nx, ny)), np.zeros((nx, ny)),
            np.zeros((nx, ny)), np.zeros((nx, ny)), np.zeros((2, nx, ny)), np.zeros((LINES, ny + 4)),
            np.zeros(ny), np.zeros(ny),
        )  # fmt: skip
        self._viscosity = viscosity if gas.conducts() else 0.0
        self._viscous = viscous_flow.Arrays.of(mesh) if self._viscosity > 0.0 else None
        self._hierarchy = multigrid.Hierarchy(mesh)
        self._last = np.zeros((4, nx, ny))  # the state before
        self._momentum = np.zeros((2, 2, nx, ny))  # of faces, in x and in y: now, and before
        self._velocity = np.zeros((2, nx, ny))  # of faces, extrapolated to the new time
        self._next, self._pushed = np.zeros((4, nx, ny)), np.zeros((2, nx, ny))
        self._unknowns = np.zeros((2, nx, ny))  # pressure, temperature
        self._missed = np.zeros((2, nx, ny))  # what the last extrapolation missed of the unknowns
        self._span = np.zeros(1)  # of that extrapolation: the product of steps that what it misses is proportional to
        self._steps = np.zeros(2)  # the last one, and the largest that the error allows next; zero at the start
        self._exchange = np.zeros(4)  # in the last step
        self.iterations = self.viscous_iterations = 0

    def limits(self, state: State) -> dict[str, float]:
        """What the remap and the error of the last step allow; for the first step, a share of the time of sound."""
        last, allowed = self._steps
        if last == 0.0:
            c = self.gas.sound_speed(state.density, state.temperature)
            width = np.minimum(self.mesh.dx[:, None], self.mesh.dy[None, :])
            return {"sound": FIRST_STEP * float(np.min(width / (c + state.speed)))}
        swept = sweep_rate(self._velocity, self.mesh.dx, self.mesh.dy)
        return {"remap": self.cfl / swept if swept > 0.0 else math.inf, "error": float(allowed)}

    def step(self, state: State, dt: float) -> Exchange:
        """Advance `state` in place by `dt`; StepRejected leaves it untouched."""
        ratio = dt / self._steps[0] if self._steps[0] > 0.0 else 0.0
        if ratio == 0.0:
            face_momenta(self._grid.heat, state.conserved, self._momentum[0])
        admissible = self._look_ahead(state.conserved, ratio)
        if not admissible:
            ratio = 0.0
            if not self._look_ahead(state.conserved, ratio):
                raise StepRejected(worst_cell(state))
        h = dt * (1.0 + ratio) / (1.0 + 2.0 * ratio)
        work, friction = self._work, 1.0 / self.tau
        carry(self.gas, self.limiter, self._grid, self._momentum, ratio, h, self._velocity, work)
        given = self._add_source(state.time + dt, h)
        if self._viscous is not None:
            self._drag(self._viscous, state.pressure, h, friction)
        span = dt * (dt + self._steps[0]) if ratio > 0.0 else 0.0
        P, T = self._unknowns
        foresee(self.gas, work.ahead, self._missed, span / self._span[0] if self._span[0] > 0.0 else 0.0, P, T)
        self._solve(h, friction)
        totals = finish(self.gas, self.wall, self._grid, P, T, h, friction, work, self._next, self._pushed)
        error = unforeseen(self.gas, self.mesh.areas, self._next, work.ahead)
        self._judge(error, dt, State(self.gas, self.mesh, self._next))
        self._span[0] = span
        miss(self.gas, work.ahead, P, T, self._missed)
        self._last[:] = state.conserved
        self._momentum[1] = self._momentum[0]
        self._momentum[0] = self._pushed
        state.conserved[:] = self._next
        state.time += dt
        return self._book(np.append(totals, given), ratio, h)

    def _look_ahead(self, now: np.ndarray, ratio: float) -> bool:
        """Extrapolate; whether n and T stay in their bounds."""
        return look_ahead(self.gas, now, self._last, ratio, self._work.ahead, self._work.base)

    def _add_source(self, time: float, h: float) -> float:
        """The source over `h`, into what the balances start from; returns the power that it gives."""
        if self.source is None:
            return 0.0
        source, work = self.source(time, self.mesh), self._work
        on_faces = self._pushed
        face_momenta(self._grid.heat, source, on_faces)
        work.base[N] += h * source[N]
        work.base[E] += h * source[E]
        work.drive_x[:] += h * on_faces[0]
        work.drive_y[:] += h * on_faces[1]
        return self.mesh.integral(source[E])

    def _drag(self, arrays: viscous_flow.Arrays, pressure: np.ndarray, h: float, friction: float) -> None:
        """Viscosity over `h`, into what the balances start from; `pressure` is that of the last state.

        Velocities are found under a pressure halfway to the extrapolated one: closer to the new one than that of the
        last state, while sound on the grid still dies; all of the extrapolation would let it swing for long.
        """
        work = self._work
        halfway = 0.5 * (pressure + work.ahead[3])
        arrays.velocity[:] = self._velocity
        iterations = viscous_flow.imply(
            self.gas, self._viscosity, self._grid.heat, halfway, work.ahead, h, friction,
            work.drive_x, work.drive_y, work.base[E], arrays,
        )  # fmt: skip
        self.viscous_iterations += iterations
        if iterations == viscous_flow.ITERATIONS:
            raise StepRejected(f"the viscous velocities do not converge in {iterations} iterations")

    def _solve(self, h: float, friction: float) -> None:
        """Pressure and temperature of the new state, from a first guess."""
        work, finest = self._work, self._hierarchy.levels[0]
        P, T = self._unknowns
        change, rate, enough = math.inf, 0.0, SOLVED
        for iteration in range(ITERATIONS):
            balance(self.gas, self.wall, self._grid, P, T, h, friction, work, finest.right)
            if iteration == 0:
                couple(self.gas, self.wall, self._grid, P, T, h, friction, work, *finest.equations())
                self._hierarchy.prepare()
            self._hierarchy.cycle()
            before, change = change, correct(finest.unknowns, P, T)
            self.iterations += 1
            if iteration == 0:
                enough = max(SOLVED, SHARE * change)
            rate = min(max(rate, change / before), SLOWEST)
            if change == 0.0 or (iteration > 0 and change * rate / (1.0 - rate) < enough):
                return
        raise StepRejected(f"the implicit stage does not converge: last change {change:.2g}")

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
        self._exchange += h * totals
        return Exchange(*self._exchange.tolist())

    def memory(self) -> dict[str, np.ndarray]:
        """The state before, momenta of the faces, what was missed, steps, the last exchange, the wall's temperature."""
        kept = {
            "last": self._last,
            "momentum": self._momentum,
            "velocity": self._velocity,
            "missed": self._missed,
            "span": self._span,
            "steps": self._steps,
            "exchange": self._exchange,
            "wall_temperature": self._work.wall_temperature,
        }
        return {name: values.copy() for name, values in kept.items()}

    def remember(self, memory: dict[str, np.ndarray]) -> None:
        """Take back what `memory` gave."""
        self._last[:], self._momentum[:] = memory["last"], memory["momentum"]
        self._velocity[:], self._missed[:] = memory["velocity"], memory["missed"]
        self._span[:] = memory["span"]
        self._steps[:], self._exchange[:] = memory["steps"], memory["exchange"]
        self._work.wall_temperature[:] = memory["wall_temperature"]


@kernel(exact=True)
def sweep_rate(velocity, dx, dy):
    """The largest share of a cell that a face sweeps per time; velocity: (2, nx, ny) of faces in x and in y."""
    largest = 0.0
    for i in range(dx.size):
        for j in range(dy.size):
            in_x = abs(velocity[0, i, j]) / min(dx[i], dx[i - 1])
            in_y = abs(velocity[1, i, j]) / min(dy[j], dy[j - 1])
            largest = max(largest, in_x, in_y)
    return largest


@kernel(exact=True)
def face_momenta(geometry, state, momentum):
    """Mean momenta of the two cells of every face; zero at walls."""
    for i in range(state.shape[1]):
        for j in range(state.shape[2]):
            open_x, open_y = i > 0 or geometry.periodic_x, j > 0 or geometry.periodic_y
            momentum[0, i, j] = 0.5 * (state[MX, i, j] + state[MX, i - 1, j]) if open_x else 0.0
            momentum[1, i, j] = 0.5 * (state[MY, i, j] + state[MY, i, j - 1]) if open_y else 0.0


@kernel(exact=True)
def look_ahead(gas, now, last, ratio, ahead, base):
    """Extrapolated n, u, v, p and the contribution of both states; False where n or T would leave its bounds."""
    weight = ratio * ratio / (1.0 + 2.0 * ratio)
    good = True
    for i in range(now.shape[1]):
        for q in range(4):
            add_difference(now[q, i], last[q, i], weight, base[q, i])
            add_difference(now[q, i], last[q, i], ratio, ahead[q, i])
        outside = primitive_row(gas, ahead[0, i], ahead[1, i], ahead[2, i], ahead[3, i])
        good = good and outside == 0
    return good


@part(exact=True)
def add_difference(now, last, weight, out):
    """out = now + weight (now - last)."""
    for j in range(np.uint64(now.size)):
        out[j] = now[j] + weight * (now[j] - last[j])


@part(exact=True)
def primitive_row(gas, density, momentum_x, momentum_y, energy):
    """Turn conserved fields of a row into n, u, v, p; returns in how many cells n or T is out of bounds."""
    outside = 0
    for j in range(np.uint64(density.size)):
        n = density[j]
        over = 1.0 / n
        u, v = momentum_x[j] * over, momentum_y[j] * over
        T = energy[j] * over - 0.5 * (u * u + v * v)
        momentum_x[j], momentum_y[j], energy[j] = u, v, gas.pressure(n, T)
        outside += 0 if (n > 0.0) & (n < 1.0) & (T > 0.0) else 1
    return outside


@kernel(exact=True)
def carry(gas, limiter, grid, momentum, ratio, h, velocity, work):
    """Swept profiles at the faces, and momentum of faces before pressure acts.

    momentum: of the faces, now and before, (2, 2, nx, ny). velocity: of the faces, extrapolated, (2, nx, ny), is set.
    """
    nx = velocity.shape[1]
    weight = ratio * ratio / (1.0 + 2.0 * ratio)
    work.stream[:] = 0.0
    for i in range(nx):
        for axis in range(2):
            add_difference(momentum[0, axis, i], momentum[1, axis, i], ratio, velocity[axis, i])
        divide_row(velocity[0, i], work.ahead[0, i - 1], work.ahead[0, i])
        divide_line(velocity[1, i], work.ahead[0, i])
        if i > 0 or grid.heat.periodic_x:
            carry_across(gas, limiter, grid, velocity[0, i], h, work, i)
    for i in range(nx):
        carry_along(gas, limiter, grid, work.ahead[:, i], velocity[1, i], h, work, i)
    for i in range(nx):
        drive_row(grid.heat, momentum[:, :, i], weight, work, i)


@part(exact=True)
def carry_across(gas, limiter, grid, velocity, h, work, i):
    """The faces in x below row i, none of them at a wall."""
    geometry, ahead, lines, spacing = grid.heat, work.ahead, work.lines, grid.spacing_x
    nx, ny = ahead.shape[1:]
    before = i - 2 if i > 1 or geometry.periodic_x else 0
    after = (i + 1) % nx if i < nx - 1 or geometry.periodic_x else i
    centre = i + GHOSTS
    upstream_row(velocity, lines[WEIGHT])
    for q in range(4):
        profile_row(
            limiter, ahead[q, before], ahead[q, i - 1], ahead[q, i], ahead[q, after],
            spacing[1, centre - 1], spacing[2, centre - 1], spacing[1, centre], spacing[2, centre],
            lines[WEIGHT], lines[PROFILES + q],
        )  # fmt: skip
    flow, energy = work.carried_x[FLOW, i], work.carried_x[ENERGY, i]
    carry_row(gas, ahead[0, i - 1], ahead[0, i], velocity, lines, flow, energy)
    for j in range(np.uint64(ny)):
        flow[j] *= geometry.dy[j]
        energy[j] *= geometry.dy[j]
    for q in range(2):
        add_row(work.stream[q, i - 1], lines[STREAMS + q], -h / geometry.dx[i - 1])
        add_row(work.stream[q, i], lines[STREAMS + q], h / geometry.dx[i])


@part(exact=True)
def drive_row(geometry, momentum, weight, work, i):
    """Momentum of the faces of row i from that of the last two states, (2, 2, ny), and what streams into its cells."""
    in_x, in_y, along = work.drive_x[i], work.drive_y[i], work.stream[1, i]
    last = in_y.size - 1
    add_difference(momentum[0, 0], momentum[1, 0], weight, in_x)
    add_difference(momentum[0, 1], momentum[1, 1], weight, in_y)
    add_row(in_x, work.stream[0, i - 1], 0.5)
    add_row(in_x, work.stream[0, i], 0.5)
    for j in range(ONE, np.uint64(in_y.size)):
        in_y[j] += 0.5 * (along[j] + along[j - ONE])
    in_y[0] = in_y[0] + 0.5 * (along[0] + along[last]) if geometry.periodic_y else 0.0
    if i == 0 and not geometry.periodic_x:
        in_x[:] = 0.0


@part(exact=True)
def divide_row(momentum, density_low, density_high):
    """Velocities of faces in x, in place of their momenta."""
    for j in range(np.uint64(momentum.size)):
        momentum[j] *= 2.0 / (density_low[j] + density_high[j])


@part(exact=True)
def divide_line(momentum, density):
    """Velocities of faces in y, in place of their momenta."""
    for j in range(ONE, np.uint64(momentum.size)):
        momentum[j] *= 2.0 / (density[j] + density[j - ONE])
    momentum[0] *= 2.0 / (density[0] + density[-1])


@part(exact=True)
def carry_along(gas, limiter, grid, row, velocity, h, work, i):
    """The faces in y of one row of cells; `row`: (4, ny)."""
    geometry, lines, spacing = grid.heat, work.lines, grid.spacing_y
    ny = row.shape[1]
    upstream_row(velocity, lines[WEIGHT])
    for q in range(4):
        padded = lines[PADDED]
        for j in range(np.uint64(ny)):
            padded[j + TWO] = row[q, j]
        for ghost in range(GHOSTS):
            padded[1 - ghost] = row[q, ny - 1 - ghost] if geometry.periodic_y else row[q, 0]
            padded[ny + GHOSTS + ghost] = row[q, ghost] if geometry.periodic_y else row[q, ny - 1]
        profile_line(limiter, padded, spacing[1], spacing[2], lines[WEIGHT], lines[PROFILES + q])
        if q == 0:
            for j in range(np.uint64(ny + 1)):
                lines[DENSITY_LOW, j], lines[DENSITY_HIGH, j] = padded[j + ONE], padded[j + TWO]
    carry_row(
        gas,
        lines[DENSITY_LOW],
        lines[DENSITY_HIGH],
        velocity,
        lines,
        work.carried_y[FLOW, i],
        work.carried_y[ENERGY, i],
    )
    if not geometry.periodic_y:
        work.carried_y[FLOW, i, 0], work.carried_y[ENERGY, i, 0] = 0.0, 0.0
    for j in range(ny):
        work.carried_y[FLOW, i, j] *= geometry.dx[i]
        work.carried_y[ENERGY, i, j] *= geometry.dx[i]
    for q in range(2):
        stream, momentum = lines[STREAMS + q], work.stream[q, i]
        stream[0] = stream[0] if geometry.periodic_y else 0.0
        stream[ny] = stream[0]
        for j in range(np.uint64(ny)):
            momentum[j] -= h / geometry.dy[j] * (stream[j + ONE] - stream[j])


@part(exact=True)
def upstream_row(velocity, weight):
    """The share of the lower side in what the faces sweep: half where nothing moves, so that mirror images stay so."""
    for j in range(np.uint64(velocity.size)):
        weight[j] = 1.0 if velocity[j] > 0.0 else (0.5 if velocity[j] == 0.0 else 0.0)


@part(exact=True)
def profile_row(limiter, f0, f1, f2, f3, low1, high1, low2, high2, weight, out):
    """Limited profiles at the faces between rows 1 and 2."""
    for j in range(np.uint64(f0.size)):
        step = f2[j] - f1[j]
        below = f1[j] + 0.5 * limiter.limited((f1[j] - f0[j]) * low1, step * high1)
        above = f2[j] - 0.5 * limiter.limited(step * low2, (f3[j] - f2[j]) * high2)
        out[j] = weight[j] * below + (1.0 - weight[j]) * above


@part(exact=True)
def profile_line(limiter, padded, low, high, weight, out):
    """Limited profiles at the faces below the cells of a padded line, (ny + 4,)."""
    for j in range(np.uint64(padded.size - 4)):
        a, b = padded[j + ONE], padded[j + TWO]
        step = b - a
        below = a + 0.5 * limiter.limited((a - padded[j]) * low[j + ONE], step * high[j + ONE])
        above = b - 0.5 * limiter.limited(step * low[j + TWO], (padded[j + TWO + ONE] - b) * high[j + TWO])
        out[j] = weight[j] * below + (1.0 - weight[j]) * above


@part(exact=True)
def carry_row(gas, density_low, density_high, velocity, lines, flow, energy):
    """What a unit of momentum at the faces carries along per length, and the momentum streaming through them."""
    n_row, u_row, v_row, p_row = lines[PROFILES], lines[PROFILES + 1], lines[PROFILES + 2], lines[PROFILES + 3]
    stream_x, stream_y = lines[STREAMS], lines[STREAMS + 1]
    for j in range(np.uint64(velocity.size)):
        n, u, v, p = n_row[j], u_row[j], v_row[j], p_row[j]
        over = 2.0 / (density_low[j] + density_high[j])
        flow[j] = n * over
        energy[j] = (p / gas.compressibility(n) + p + 0.5 * n * (u * u + v * v)) * over
        stream_x[j], stream_y[j] = n * velocity[j] * u, n * velocity[j] * v


@part(exact=True)
def add_row(target, values, factor):
    """target += factor values."""
    for j in range(np.uint64(target.size)):
        target[j] += factor * values[j]


@kernel(exact=True)
def foresee(gas, ahead, missed, share, P, T):
    """A first guess of the unknowns: `ahead`, and `share` of what it missed the last time, at most half of itself."""
    for i in range(P.shape[0]):
        density, pressure, missed_P, missed_T = ahead[0, i], ahead[3, i], missed[0, i], missed[1, i]
        P_row, T_row = P[i], T[i]
        for j in range(np.uint64(P_row.size)):
            p = pressure[j]
            t = gas.temperature(density[j], p)
            P_row[j] = p + max(-0.5 * p, min(0.5 * p, share * missed_P[j]))
            T_row[j] = t + max(-0.5 * t, min(0.5 * t, share * missed_T[j]))


@kernel(exact=True)
def miss(gas, ahead, P, T, missed):
    """What the extrapolation `ahead` missed of the unknowns; to leading order the curvature in time."""
    for i in range(P.shape[0]):
        density, pressure, missed_P, missed_T = ahead[0, i], ahead[3, i], missed[0, i], missed[1, i]
        P_row, T_row = P[i], T[i]
        for j in range(np.uint64(P_row.size)):
            missed_P[j] = P_row[j] - pressure[j]
            missed_T[j] = T_row[j] - gas.temperature(density[j], pressure[j])


@part(exact=True)
def closures(gas, P, T, work):
    """Density, conductivity and cooling of all cells for the unknowns."""
    for i in range(P.shape[0]):
        closures_row(gas, P[i], T[i], work.density[i], work.kappa[i], work.cooling[i])


@part(exact=True)
def closures_row(gas, P, T, density, kappa, cooling):
    """One row of cells."""
    for j in range(np.uint64(P.size)):
        n = gas.density(P[j], T[j])
        root = np.sqrt(T[j])
        density[j] = n
        kappa[j] = gas.conductivity_coefficient(n) * root
        cooling[j] = gas.cooling_coefficient(n) * T[j] * root


@part(exact=True)
def heat_wall(gas, wall, geometry, density, T, work):
    """Heat flux from the driving wall, from the last row of cells."""
    if geometry.periodic_x or not gas.conducts():
        return
    for j in range(T.size):
        guess = work.wall_temperature[j] if work.wall_temperature[j] > 0.0 else T[j]
        half_width = 0.5 * geometry.dx[-1]
        work.wall_flux[j], work.wall_temperature[j] = wall.face(gas, density[j], T[j], half_width, guess)


@part(exact=True)
def face_row(P, P_high, T, T_high, kappa, kappa_high, drive, flow, energy, inverse, length, h, slow, lines, side):
    """Momentum, mass, energy and heat through the faces in x between two rows, into lines `side` and following."""
    push, mass, carried, heat = lines[side], lines[side + 1], lines[side + 2], lines[side + 3]
    for j in range(np.uint64(P.size)):
        momentum = slow * (drive[j] - h * (P_high[j] - P[j]) * inverse)
        push[j] = momentum
        mass[j] = flow[j] * momentum
        carried[j] = energy[j] * momentum
        heat[j] = 0.5 * inverse * length[j] * (kappa[j] + kappa_high[j]) * (T_high[j] - T[j])


@part(exact=True)
def face_line(geometry, P, T, kappa, drive, flow, energy, width, h, slow, lines):
    """The same for the faces in y of a row of cells; entry j is the face below cell j, the last one that above."""
    push, mass, carried, heat = lines[ALONG], lines[ALONG + 1], lines[ALONG + 2], lines[ALONG + 3]
    inverse = geometry.inverse_y
    for j in range(ONE, np.uint64(P.size)):
        momentum = slow * (drive[j] - h * (P[j] - P[j - ONE]) * inverse[j])
        push[j] = momentum
        mass[j] = flow[j] * momentum
        carried[j] = energy[j] * momentum
        heat[j] = 0.5 * inverse[j] * width * (kappa[j - ONE] + kappa[j]) * (T[j] - T[j - ONE])
    last = P.size - 1
    push[0], mass[0], carried[0], heat[0] = 0.0, 0.0, 0.0, 0.0
    if geometry.periodic_y:
        push[0] = slow * (drive[0] - h * (P[0] - P[last]) * inverse[0])
        mass[0], carried[0] = flow[0] * push[0], energy[0] * push[0]
        heat[0] = 0.5 * inverse[0] * width * (kappa[last] + kappa[0]) * (T[0] - T[last])
    push[last + 1], mass[last + 1], carried[last + 1], heat[last + 1] = push[0], mass[0], carried[0], heat[0]


@part(exact=True)
def fluxes(grid, P, T, h, slow, work, i):
    """What crosses the faces of row i, after those of row i-1; returns the places of the lower and upper lines."""
    geometry, lines = grid.heat, work.lines
    nx = P.shape[0]
    low, high = (EVEN, ODD) if i % 2 == 0 else (ODD, EVEN)
    if i == 0:
        before = nx - 1 if geometry.periodic_x else 0
        face_row(P[before], P[0], T[before], T[0], work.kappa[before], work.kappa[0], work.drive_x[0],
                 work.carried_x[FLOW, 0], work.carried_x[ENERGY, 0], geometry.inverse_x[0], geometry.dy, h, slow,
                 lines, low)  # fmt: skip
    k = i + 1 if i < nx - 1 else 0
    after = k if i < nx - 1 or geometry.periodic_x else i
    face_row(P[i], P[after], T[i], T[after], work.kappa[i], work.kappa[after], work.drive_x[k],
             work.carried_x[FLOW, k], work.carried_x[ENERGY, k], geometry.inverse_x[i + 1], geometry.dy, h, slow,
             lines, high)  # fmt: skip
    if i == nx - 1 and not geometry.periodic_x:
        heat = lines[high + 3]
        for j in range(np.uint64(P.shape[1])):
            heat[j] = work.wall_flux[j] * geometry.dy[j]
    face_line(geometry, P[i], T[i], work.kappa[i], work.drive_y[i], work.carried_y[FLOW, i], work.carried_y[ENERGY, i],
              geometry.dx[i], h, slow, lines)  # fmt: skip
    return low, high


@part(exact=True)
def mean_of_faces(lines, low, high, count):
    """Momentum of a row of cells after pressure and friction have acted: the mean of its faces', into two lines."""
    below, above, along = lines[low], lines[high], lines[ALONG]
    in_x, in_y = lines[PUSHED], lines[PUSHED + 1]
    for j in range(np.uint64(count)):
        in_x[j] = 0.5 * (below[j] + above[j])
        in_y[j] = 0.5 * (along[j] + along[j + ONE])


@kernel(exact=True)
def balance(gas, wall, grid, P, T, h, friction, work, right):
    """What is missing in the balances of mass and energy of every cell, into `right` (nx, 2, ny)."""
    geometry, slow = grid.heat, 1.0 / (1.0 + h * friction)
    closures(gas, P, T, work)
    heat_wall(gas, wall, geometry, work.density[-1], T[-1], work)
    for i in range(P.shape[0]):
        low, high = fluxes(grid, P, T, h, slow, work, i)
        mean_of_faces(work.lines, low, high, P.shape[1])
        balance_row(
            work.density[i], work.cooling[i], T[i], work.base[N, i], work.base[E, i], geometry.dx[i], geometry.dy, h,
            friction, work.lines, low, high, right[i, 0], right[i, 1],
        )  # fmt: skip


@part(exact=True)
def balance_row(density, cooling, T, base_n, base_e, width, dy, h, friction, lines, low, high, right_n, right_e):
    """One row of cells."""
    mass_l, energy_l, heat_l = lines[low + 1], lines[low + 2], lines[low + 3]
    mass_h, energy_h, heat_h = lines[high + 1], lines[high + 2], lines[high + 3]
    mass_y, energy_y, heat_y = lines[ALONG + 1], lines[ALONG + 2], lines[ALONG + 3]
    push_x, push_y = lines[PUSHED], lines[PUSHED + 1]
    for j in range(np.uint64(T.size)):
        area = width * dy[j]
        mass = (mass_h[j] - mass_l[j]) + (mass_y[j + ONE] - mass_y[j])
        energy = (energy_h[j] - energy_l[j]) + (energy_y[j + ONE] - energy_y[j])
        heat = (heat_h[j] - heat_l[j]) + (heat_y[j + ONE] - heat_y[j])
        n = density[j]
        kinetic = 0.5 * (push_x[j] * push_x[j] + push_y[j] * push_y[j]) / n
        right_n[j] = area * (base_n[j] - n) - h * mass
        stored = n * T[j] + kinetic - base_e[j]
        right_e[j] = h * (heat - energy) - area * (stored + h * (cooling[j] + 2.0 * friction * kinetic))


@kernel(exact=True)
def couple(gas, wall, grid, P, T, h, friction, work, local, faces_x, faces_y, stencil):
    """Derivatives of the balances, for `multigrid`: local terms, couplings across faces, stencils. After `balance`."""
    geometry = grid.heat
    nx = P.shape[0]
    push = h * h / (1.0 + h * friction)
    for i in range(nx):
        couple_cells(
            gas, work.density[i], T[i], geometry.dx[i], geometry.dy, h, local[i, 0], local[i, 1], local[i, 2],
            local[i, 3], work.kappa_slopes[0, i], work.kappa_slopes[1, i],
        )  # fmt: skip
    couple_wall(gas, wall, geometry, work.density[-1], T[-1], h, work.wall_temperature, local[-1, 2], local[-1, 3])
    for i in range(nx):
        if i > 0 or geometry.periodic_x:
            inverse = geometry.inverse_x[i]
            couple_faces(
                T[i - 1], T[i], work.kappa[i - 1], work.kappa[i], work.kappa_slopes[0, i - 1], work.kappa_slopes[0, i],
                work.kappa_slopes[1, i - 1], work.kappa_slopes[1, i], work.carried_x[FLOW, i],
                work.carried_x[ENERGY, i], push * inverse, 0.5 * h * inverse, geometry.dy, faces_x, i,
            )  # fmt: skip
        couple_line(
            geometry, T[i], work.kappa[i], work.kappa_slopes[0, i], work.kappa_slopes[1, i], work.carried_y[FLOW, i],
            work.carried_y[ENERGY, i], push, 0.5 * h * geometry.dx[i], faces_y, i,
        )  # fmt: skip
        if i > 0:
            multigrid.build_row(local, faces_x, faces_y, i - 1, stencil)
    multigrid.build_row(local, faces_x, faces_y, nx - 1, stencil)


@part(exact=True)
def couple_cells(gas, density, T, width, dy, h, l11, l12, l21, l22, kappa_P, kappa_T):
    """Local terms of one row of cells, and the slopes of its conductivities in P and in T."""
    for j in range(np.uint64(density.size)):
        area, n, here = width * dy[j], density[j], T[j]
        n_P, n_T = gas.density_slopes(n, here)
        i_n, i_T = gas.cooling_slopes(n, here)
        k_n, k_T = gas.conductivity_slopes(n, here)
        l11[j], l12[j] = area * n_P, area * n_T
        l21[j] = area * (n_P * here + h * i_n * n_P)
        l22[j] = area * (n + n_T * here + h * (i_n * n_T + i_T))
        kappa_P[j], kappa_T[j] = k_n * n_P, k_T + k_n * n_T


@part(exact=True)
def couple_wall(gas, wall, geometry, density, T, h, wall_temperature, l21, l22):
    """The derivatives of the wall's heat, into the local terms of the last row of cells."""
    if geometry.periodic_x or not gas.conducts():
        return
    for j in range(T.size):
        n, here = density[j], T[j]
        in_n, in_T = wall.face_slopes(gas, n, here, 0.5 * geometry.dx[-1], wall_temperature[j])
        n_P, n_T = gas.density_slopes(n, here)
        l21[j] -= h * geometry.dy[j] * in_n * n_P
        l22[j] -= h * geometry.dy[j] * (in_T + in_n * n_T)


@part(exact=True)
def couple_faces(Ta, Tb, ka, kb, ka_P, kb_P, ka_T, kb_T, flow, energy, push, conductance, length, faces, i):
    """Couplings across the faces in x between two rows of cells."""
    mass, energy_p, energy_t = faces[i, multigrid.MASS], faces[i, multigrid.ENERGY_P], faces[i, multigrid.ENERGY_T]
    drift_pa, drift_pb = faces[i, multigrid.DRIFT_PA], faces[i, multigrid.DRIFT_PB]
    drift_ta, drift_tb = faces[i, multigrid.DRIFT_TA], faces[i, multigrid.DRIFT_TB]
    for j in range(np.uint64(Ta.size)):
        mass[j], energy_p[j] = push * flow[j], push * energy[j]
        share = conductance * length[j]
        lever = share * (Tb[j] - Ta[j])
        energy_t[j] = share * (ka[j] + kb[j])
        drift_pa[j], drift_pb[j] = lever * ka_P[j], lever * kb_P[j]
        drift_ta[j], drift_tb[j] = lever * ka_T[j], lever * kb_T[j]


@part(exact=True)
def couple_line(geometry, T, kappa, kappa_P, kappa_T, flow, energy, push, conductance, faces, i):
    """Couplings across the faces in y of row i."""
    mass, energy_p, energy_t = faces[i, multigrid.MASS], faces[i, multigrid.ENERGY_P], faces[i, multigrid.ENERGY_T]
    drift_pa, drift_pb = faces[i, multigrid.DRIFT_PA], faces[i, multigrid.DRIFT_PB]
    drift_ta, drift_tb = faces[i, multigrid.DRIFT_TA], faces[i, multigrid.DRIFT_TB]
    inverse, last = geometry.inverse_y, np.uint64(T.size) - ONE
    for j in range(ZERO if geometry.periodic_y else ONE, last + ONE):
        k = j - ONE if j > ZERO else last
        mass[j], energy_p[j] = push * inverse[j] * flow[j], push * inverse[j] * energy[j]
        share = conductance * inverse[j]
        lever = share * (T[j] - T[k])
        energy_t[j] = share * (kappa[k] + kappa[j])
        drift_pa[j], drift_pb[j] = lever * kappa_P[k], lever * kappa_P[j]
        drift_ta[j], drift_tb[j] = lever * kappa_T[k], lever * kappa_T[j]


@kernel(exact=True)
def correct(change, P, T):
    """Change the unknowns by what the cycle suggests, (nx, 2, ny + 2); returns its largest relative change.

    No unknown changes by more than half.
    """
    largest = 0.0
    for i in range(P.shape[0]):
        for q, unknown in enumerate((P, T)):
            wanted, values = change[i, q], unknown[i]
            for j in range(np.uint64(values.size)):
                size = abs(wanted[j + ONE] / values[j])
                largest = largest if size <= largest else size
    share = min(1.0, 0.5 / largest) if largest > 0.0 else 1.0
    for i in range(P.shape[0]):
        for q, unknown in enumerate((P, T)):
            wanted, values = change[i, q], unknown[i]
            for j in range(np.uint64(values.size)):
                values[j] += share * wanted[j + ONE]
    return largest


@kernel
def finish(gas, wall, grid, P, T, h, friction, work, state, momentum):
    """The new state (4, nx, ny) from the unknowns, and the momenta of the faces (2, nx, ny).

    Returns powers: given by the wall, lost in collisions, lost by friction. The iteration leaves a little of the
    balances; a common factor on density, and one on energy, makes up for it: mass and the books of energy are exact.
    """
    geometry, slow = grid.heat, 1.0 / (1.0 + h * friction)
    closures(gas, P, T, work)
    heat_wall(gas, wall, geometry, work.density[-1], T[-1], work)
    totals, lines = np.zeros(3), work.lines
    mass, energy, base_mass, base_energy = 0.0, 0.0, 0.0, 0.0
    for i in range(P.shape[0]):
        low, high = fluxes(grid, P, T, h, slow, work, i)
        mean_of_faces(lines, low, high, P.shape[1])
        finish_row(work.density[i], T[i], lines, state[N, i], state[MX, i], state[MY, i], state[E, i])
        sums = sums_of_row(
            state[N, i], state[MX, i], state[MY, i], state[E, i], work.cooling[i], work.base[N, i], work.base[E, i],
            geometry.dy, friction,
        )  # fmt: skip
        width = geometry.dx[i]
        mass, energy = mass + width * sums[0], energy + width * sums[1]
        base_mass, base_energy = base_mass + width * sums[2], base_energy + width * sums[3]
        totals[LOST] += width * sums[4]
        totals[RUBBED] += width * sums[5]
        momentum[0, i] = lines[low, : P.shape[1]]
        momentum[1, i] = lines[ALONG, : P.shape[1]]
    if not geometry.periodic_x:
        for j in range(P.shape[1]):
            totals[HEAT_IN] += work.wall_flux[j] * geometry.dy[j]
    state[N] *= base_mass / mass
    state[E] *= (base_energy + h * (totals[HEAT_IN] - totals[LOST] - totals[RUBBED])) / energy
    return totals


@part(exact=True)
def finish_row(density, T, lines, new_n, new_x, new_y, new_e):
    """The new state of one row of cells."""
    push_x, push_y = lines[PUSHED], lines[PUSHED + 1]
    for j in range(np.uint64(density.size)):
        n = density[j]
        kinetic = 0.5 * (push_x[j] * push_x[j] + push_y[j] * push_y[j]) / n
        new_n[j], new_x[j], new_y[j], new_e[j] = n, push_x[j], push_y[j], n * T[j] + kinetic


@part
def sums_of_row(density, momentum_x, momentum_y, energy, cooling, base_n, base_e, dy, friction):
    """Of one row, per width: its mass, energy, those of the base, powers of collisions and friction."""
    mass, total, base_mass, base_energy, lost, rubbed = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(np.uint64(density.size)):
        mass += dy[j] * density[j]
        total += dy[j] * energy[j]
        base_mass += dy[j] * base_n[j]
        base_energy += dy[j] * base_e[j]
        lost += dy[j] * cooling[j]
        twice_kinetic = (momentum_x[j] * momentum_x[j] + momentum_y[j] * momentum_y[j]) / density[j]
        rubbed += dy[j] * friction * twice_kinetic
    return mass, total, base_mass, base_energy, lost, rubbed


@kernel
def unforeseen(gas, areas, state, ahead):
    """Root mean square, over the box, of what the extrapolation `ahead` (n, u, v, p) missed; infinite out of bounds.

    Density and pressure relative, velocity against sound.
    """
    total, area = 0.0, 0.0
    for i in range(areas.shape[0]):
        missed, covered, outside = unforeseen_row(
            gas, areas[i], state[N, i], state[MX, i], state[MY, i], state[E, i],
            ahead[0, i], ahead[1, i], ahead[2, i], ahead[3, i],
        )  # fmt: skip
        if outside > 0:
            return np.inf
        total, area = total + missed, area + covered
    return np.sqrt(total / area)


@part
def unforeseen_row(gas, areas, density, momentum_x, momentum_y, energy, n_ahead, u_ahead, v_ahead, p_ahead):
    """Of one row: the sum of squares, times areas, of what was missed; the area; how many cells are out of bounds."""
    total, area, outside = 0.0, 0.0, 0
    for j in range(np.uint64(areas.size)):
        n = density[j]
        over = 1.0 / n
        u, v = momentum_x[j] * over, momentum_y[j] * over
        T = energy[j] * over - 0.5 * (u * u + v * v)
        p = gas.pressure(n, T)
        over_c = 1.0 / gas.sound_speed_at_pressure(n, p)
        in_n, in_p = n_ahead[j] * over - 1.0, p_ahead[j] / p - 1.0
        in_u, in_v = (u_ahead[j] - u) * over_c, (v_ahead[j] - v) * over_c
        total += areas[j] * (in_n * in_n + in_p * in_p + in_u * in_u + in_v * in_v)
        area += areas[j]
        outside += 0 if (n > 0.0) & (n < 1.0) & (T > 0.0) else 1
    return total, area, outside
