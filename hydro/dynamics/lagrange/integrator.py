"""The steps of the implicit integrator."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, ClassVar

import numpy as np

from hydro.accounts import COLLISIONS, INTERNAL, WALL, Amounts
from hydro.choices import LIMITERS
from hydro.dynamics import multigrid
from hydro.dynamics.integrator import Integrator, Remedy, flow_accounts, flow_limits
from hydro.dynamics.lagrange.balance import balance, find_closures
from hydro.dynamics.lagrange.cold import SHARE as COLD
from hydro.dynamics.lagrange.cold import ColdCells
from hydro.dynamics.lagrange.completion import complete
from hydro.dynamics.lagrange.extrapolation import extrapolation_error, first_guess, look_ahead, unforeseen_change
from hydro.dynamics.lagrange.jacobian import correct, find_jacobian
from hydro.dynamics.lagrange.shocks import CROSSING, Shocks
from hydro.dynamics.lagrange.sound import Sound, Unresolved
from hydro.dynamics.lagrange.transport import carry, face_momenta, sweep_rate
from hydro.dynamics.lagrange.workspace import Work
from hydro.errors import StepRejected
from hydro.fields import MX, MY, E, N, P, U, V
from hydro.gas import Closure
from hydro.mesh import Faces, Geometry, Mesh
from hydro.setup import elastic_below
from hydro.state import State, worst_cell
from hydro.terms import Term, Terms
from hydro.terms.together import Given
from hydro.walls.boundary import REMEMBERED, Boundary

TOLERANCE = 3e-4  # when a deck gives none
LONGER, SHORTER = 1.5, 0.3  # limits of a change of the step
SAFETY = 0.9
REJECTED = 2.0  # times the tolerance
SOLVED = 1e-10  # largest relative error of pressure and temperature, by changes and contraction; or SHARE of the first
SHARE = 1e-3  # of what the first guess missed that may stay: little beside the error of the step
SLOWEST = 0.99  # contraction of the iteration that this estimate reckons with; it takes the slowest in a step
ITERATIONS = 40
PATIENCE, ROUND_OFF = 8, 2e-15  # from then on changes below that, over the smallest gap 1 - n/n_p, are round-off
STEPS_OF_FIG4 = 18.0  # over the root of the tolerance
FIRST_STEP = 0.1  # of the time in which sound crosses a cell


class LagrangeRemap(Integrator):
    """Semi-implicit Lagrange-remap finite volumes, second order in time and space.

    walls: the law of the driving wall at x = 1, or `Walls`. terms: beside flow and heat; see `hydro.terms`. cfl:
    largest share of a cell that a face may sweep in a step. tolerance: largest root mean square change, relative, of
    density and pressure (and of the velocity, against sound) that the last two states do not foresee. elastic_below:
    see `hydro.gas.elastic`. State and work space take 622 bytes per cell. ValueError for a mesh of a single cell in a
    direction.
    """

    remembered: ClassVar = {
        "last": ("fields at the step before: density, momentum along x and y, energy", "n_c, n_c T_*^(1/2), n_c T_*"),
        "momentum_x": ("momentum density of faces in x, now and at the step before", "n_c T_*^(1/2)"),
        "momentum_y": ("momentum density of faces in y, now and at the step before", "n_c T_*^(1/2)"),
        "velocity_x": ("velocity of faces in x, extrapolated", "T_*^(1/2)"),
        "velocity_y": ("velocity of faces in y, extrapolated", "T_*^(1/2)"),
        "extrapolation_error": ("what the last extrapolation missed of pressure and temperature", "n_c T_*, T_*"),
        "span": ("product of the steps of that extrapolation", "L_x^2/T_*"),
        "steps": ("the last step, and the largest that the error allows for the next", "L_x/T_*^(1/2)"),
        "shared": ("whether faces share their momentum with cells by mass", "1"),
        "unresolved_sound": (
            "sound not resolved: largest amplitude, fewest steps in a period, shortest period",
            "1, 1, L_x/T_*^(1/2)",
        ),
        "exchange": ("energies exchanged in the last step, in the order of the ledger", "n_c T_* L_x^2"),
        **REMEMBERED,
    }
    remedies = (
        Remedy("time.integrator=godunov", lambda deck: True),
        Remedy("time.integrator=godunov scheme.limiter=minmod", lambda deck: True),
    )
    seconds_per_cell_step, bytes_per_cell = 5e-7, 622

    @staticmethod
    def options(deck: Any) -> dict[str, Any]:
        return {
            "cfl": deck.time.cfl,
            "limiter": deck.scheme.limiter,
            "tolerance": deck.time.tolerance,
            "elastic_below": elastic_below(deck),
        }

    @staticmethod
    def expected_steps(deck: Any, by_sound: float) -> tuple[float, str]:
        return STEPS_OF_FIG4 / math.sqrt(deck.time.tolerance), "as in Fig. 4 at this tolerance"

    def __init__(
        self,
        gas: Closure,
        walls: Any,
        mesh: Mesh,
        terms: Iterable[Term] = (),
        cfl: float = 0.8,
        limiter: str = "van_leer",
        tolerance: float = TOLERANCE,
        elastic_below: float = 0.0,
    ):
        if min(mesh.cells) < 2:
            raise ValueError(f"{mesh.cells} cells: two or more are needed in both directions")
        self.gas, self.mesh, self.terms, self.cfl, self.tolerance = gas, mesh, Terms(terms), cfl, tolerance
        self.elastic_below = elastic_below
        self.accounts, self.step_limits = flow_accounts(self.terms), (*flow_limits(self.terms), "shock")
        self.limiter, self.boundary = LIMITERS[limiter], Boundary(gas, walls, mesh)
        self._geometry, self._work = Geometry.of(mesh), Work.of(mesh)
        self.stresses = self.terms.stresses(gas, self.boundary, mesh)
        self._cold = ColdCells(gas, self._geometry, self.boundary.sides, mesh)
        self._shocks = Shocks(gas, self.boundary, mesh)
        self._unresolved = Unresolved()
        self._hierarchy = multigrid.Hierarchy(mesh)
        self._last = np.zeros((4, *mesh.cells))  # the state before
        self._momentum, self._momentum_before, self._pushed = (Faces.of(mesh) for _ in range(3))
        self._velocity = Faces.of(mesh)  # extrapolated to the new time
        self._next = np.zeros((4, *mesh.cells))
        self._unknowns = np.zeros((2, *mesh.cells))  # pressure, temperature
        self._extrapolation_error = np.zeros((2, *mesh.cells))  # what the last extrapolation missed of the unknowns
        self._span = np.zeros(1)  # of that extrapolation: the product of steps that what it misses is proportional to
        self._steps = np.zeros(2)  # the last one, and the largest that the error allows next; zero at the start
        self._exchange = np.zeros(len(self.accounts))  # in the last step
        self.iterations = 0

    def limits(self, state: State) -> dict[str, float]:
        """What the remap and the error of the last step allow; for the first step, a share of the time of sound."""
        self._survey(state)
        last, allowed = self._steps
        if last == 0.0:
            c = self.gas.sound_speed(state.density, state.temperature)
            width = np.minimum(self.mesh.dx[:, None], self.mesh.dy[None, :])
            return {"sound": FIRST_STEP * float(np.min(width / (c + state.speed))), **self.terms.limits(state)}
        swept = sweep_rate(self._velocity, self.mesh.dx, self.mesh.dy)
        remap = self.cfl / swept if swept > 0.0 else math.inf
        shock = CROSSING / self._shocks.rate if self._shocks.rate > 0.0 else math.inf
        return {"remap": remap, "error": float(allowed), "shock": shock, **self.terms.limits(state)}

    def step(self, state: State, dt: float) -> dict[str, float]:
        """Advance `state` in place by `dt`; StepRejected leaves it untouched."""
        self._survey(state)
        ratio = self._extrapolate(state, dt)
        h, drag = dt * (1.0 + ratio) / (1.0 + 2.0 * ratio), self.terms.drag_rate
        work, (P, T) = self._work, self._unknowns
        carry(
            self.gas, self.limiter, self._geometry, self._momentum, self._momentum_before, ratio, h, self._velocity,
            work,
        )  # fmt: skip
        self._cold.carry(self.limiter, self._velocity, work)
        self._shocks.steer(self.limiter, self._velocity, h, work)
        powers = self._add_terms(state.time + dt, h)
        self._apply_stresses(h, drag)
        span = dt * (dt + self._steps[0]) if ratio > 0.0 else 0.0
        first_guess(
            self.gas, work.ahead, self._extrapolation_error, span / self._span[0] if self._span[0] > 0.0 else 0.0, P, T
        )
        self._solve(h, drag)
        heat, added = self._find_heat(), self._energy_added(h, drag)
        powers[WALL.name], powers[COLLISIONS.name], dragged = complete(
            self._geometry, self.boundary.sides, P, T, h, drag, heat, added, work, self._next, self._pushed
        )
        powers[INTERNAL.name] = added / h
        powers.add(self.terms.drag_losses(dragged))
        error = unforeseen_change(self.gas, self._geometry, self._next, work)
        self._choose_step(error, dt, State(self.gas, self.mesh, self._next))
        self._unresolved.note(Sound.measured(self.mesh, state.conserved, self._shocks.pressure, self._shocks.sound), dt)
        self._span[0] = span
        extrapolation_error(self.gas, work.ahead, P, T, self._extrapolation_error)
        self._last[:] = state.conserved
        self._momentum_before, self._momentum, self._pushed = self._momentum, self._pushed, self._momentum_before
        state.conserved[:] = self._next
        self._shocks.forget()
        state.time += dt
        return self._book(powers, ratio, h)

    def _survey(self, state: State) -> None:
        """Look for shocks. From the first of a run on faces share their momentum by mass; steps start anew with it."""
        self._shocks.survey(state.conserved, self._work)
        if self._shocks.rate > 0.0 and not self._work.shared[0]:
            self._work.shared[0] = True
            self._steps[:] = 0.0

    def _extrapolate(self, state: State, dt: float) -> float:
        """Look ahead from the last two states, or from the last one; returns the ratio of the steps, zero for one."""
        now = state.conserved
        ratio = dt / self._steps[0] if self._steps[0] > 0.0 else 0.0
        if ratio == 0.0:
            face_momenta(self._geometry, now, self._momentum)
        for choice in (ratio, 0.0):
            if self._look_ahead(now, choice):
                return choice
        raise StepRejected(worst_cell(state))

    def _look_ahead(self, now: np.ndarray, ratio: float) -> bool:
        """Extrapolate; whether n and T stay in their bounds."""
        work, last = self._work, self._last
        good, cold = look_ahead(self.gas, self.mesh.periodic[0], now, last, ratio, COLD, work.ahead, work.base)
        self._cold.any = False
        return self._cold.look_ahead(now, last, ratio, work.ahead) if cold > 0 else good

    def _add_terms(self, time: float, h: float) -> Amounts:
        """Sources and forces over `h`, into what the balances start from; returns their powers by account."""
        work, powers = self._work, Amounts.of(self.accounts)
        given = [*self.terms.rates(time, self.mesh), *self._force_rates(time)]
        for account, rates in given:
            on_faces = self._pushed
            face_momenta(self._geometry, rates, on_faces)
            work.base[N] += h * rates[N]
            work.base[E] += h * rates[E]
            work.momentum.x[:] += h * on_faces.x
            work.momentum.y[:] += h * on_faces.y
            if self._cold.any:
                self._cold.add_heat(heat_of(rates, work.foreseen(U), work.foreseen(V)), h)
            powers.add_to(account, self.mesh.integral(rates[E]))
        return powers

    def _force_rates(self, time: float) -> list[Given]:
        """The rates of the conserved fields that forces make in the extrapolated state, each (4, nx, ny)."""
        n, u, v, p = (self._work.foreseen(field) for field in (N, U, V, P))
        if not self.terms.forcing:
            return []
        ahead = State.of(self.gas, self.mesh, n, self.gas.temperature(n, p), (u, v), time)
        return [
            Given(account, np.array([np.zeros_like(n), n * force[0], n * force[1], n * (u * force[0] + v * force[1])]))
            for account, force in self.terms.forces(time, ahead)
        ]

    def _apply_stresses(self, h: float, drag: float) -> None:
        """Stresses over `h`, into what the balances start from, and artificial viscosity.

        Velocities are found under a pressure halfway to the extrapolated one: closer to the new one than that of the
        last state, while sound on the grid still dies; all of the extrapolation would let it swing for long.
        """
        work, pressure = self._work, self._shocks.pressure
        for stress in self.stresses:
            halfway = 0.5 * (pressure + work.foreseen(P))
            heating = stress.implicit(
                self._velocity, work.foreseen(N), work.foreseen(P), halfway, h, drag, work.momentum, work.base[E]
            )
            self._cold.add_heat(heating, h)
        heating = self._shocks.resist(self._velocity, h, drag, work)
        if heating is not None:
            self._cold.add_heat(heating, h)

    def _find_heat(self) -> float:
        """Closures and the heat of the walls for the unknowns; returns the power of the walls."""
        pressure, temperature = self._unknowns
        find_closures(self.gas, self.elastic_below, pressure, temperature, self._work)
        return self.boundary.give_heat(self._work.density, temperature)

    def _solve(self, h: float, drag: float) -> None:
        """Pressure and temperature of the new state, from a first guess."""
        work, finest, geometry, sides = self._work, self._hierarchy.levels[0], self._geometry, self.boundary.sides
        P, T = self._unknowns
        change, rate, enough = math.inf, 0.0, SOLVED
        for iteration in range(ITERATIONS):
            self._find_heat()
            balance(geometry, sides, P, T, h, drag, work, finest.right)
            self._cold.balance(P, T, h, drag, work, finest.right)
            if iteration == 0:
                self.boundary.give_slopes()
                find_jacobian(self.gas, self.elastic_below, geometry, sides, T, h, drag, work, finest.equations)
                self._hierarchy.prepare()
            self._hierarchy.cycle()
            before, change = change, correct(finest.unknowns, P, T)
            self.iterations += 1
            if iteration == 0:
                enough = max(SOLVED, SHARE * change)
            rate = min(max(rate, change / before), SLOWEST)
            if change == 0.0 or (iteration > 0 and change * rate / (1.0 - rate) < enough):
                return
            if iteration >= PATIENCE and change * float(self.gas.gap(work.density).min()) < ROUND_OFF:
                return
        raise StepRejected(f"the implicit stage does not converge: last change {change:.2g}")

    def _energy_added(self, h: float, drag: float) -> float:
        """What cold cells get in this step beside the balances of total energy."""
        if not self._cold.any:
            return 0.0
        (P, T), right = self._unknowns, self._hierarchy.levels[0].right
        balance(self._geometry, self.boundary.sides, P, T, h, drag, self._work, right)
        return self._cold.energy_added(right)

    def _choose_step(self, error: float, dt: float, trial: State) -> None:
        """Choose the next step; StepRejected if this one changed more than foreseen, or left the bounds."""
        if not error < math.inf:
            raise StepRejected(worst_cell(trial))
        factor = SAFETY * math.sqrt(self.tolerance / max(error, 1e-300))
        if error > REJECTED * self.tolerance and self._steps[0] > 0.0:
            raise StepRejected(f"the change not foreseen is {error:.2g}, the tolerance {self.tolerance:.2g}")
        self._steps[:] = dt, dt * min(max(factor, SHORTER), LONGER)

    def _book(self, powers: Amounts, ratio: float, h: float) -> dict[str, float]:
        """Energies exchanged: the backward difference passes a share of the last step's on."""
        share = ratio**2 / (1.0 + 2.0 * ratio)
        self._exchange *= share
        self._exchange += h * np.array([powers[account.name] for account in self.accounts])
        return {account.name: float(energy) for account, energy in zip(self.accounts, self._exchange, strict=True)}

    def resolution(self) -> dict[str, Any]:
        """Whether the steps so far have resolved the sound that was there."""
        return self._unresolved.summary()

    def memory(self) -> dict[str, np.ndarray]:
        """Copies of what `remembered` names."""
        now, before = self._momentum, self._momentum_before
        kept = {
            "last": self._last,
            "momentum_x": np.array([now.x, before.x]),
            "momentum_y": np.array([now.y, before.y]),
            "velocity_x": self._velocity.x,
            "velocity_y": self._velocity.y,
            "extrapolation_error": self._extrapolation_error,
            "span": self._span,
            "steps": self._steps,
            "shared": self._work.shared,
            "unresolved_sound": self._unresolved.memory,
            "exchange": self._exchange,
        }
        return {name: values.copy() for name, values in kept.items()} | self.boundary.temperatures()

    def remember(self, memory: dict[str, np.ndarray]) -> None:
        """Take back what `memory` gave."""
        self._shocks.forget()
        self._last[:] = memory["last"]
        self._momentum.x[:], self._momentum_before.x[:] = memory["momentum_x"]
        self._momentum.y[:], self._momentum_before.y[:] = memory["momentum_y"]
        self._velocity.x[:], self._velocity.y[:] = memory["velocity_x"], memory["velocity_y"]
        self._extrapolation_error[:], self._span[:] = memory["extrapolation_error"], memory["span"]
        self._steps[:], self._exchange[:] = memory["steps"], memory["exchange"]
        self._work.shared[:] = memory["shared"]
        self._unresolved.memory[:] = memory["unresolved_sound"]
        self.boundary.take_temperatures(memory)


def heat_of(rates: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """The rate of internal energy in rates of the conserved fields (4, nx, ny) of gas with the velocity (u, v)."""
    return rates[E] - u * (rates[MX] - 0.5 * u * rates[N]) - v * (rates[MY] - 0.5 * v * rates[N])
