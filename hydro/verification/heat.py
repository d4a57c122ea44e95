"""Cooling, conduction, friction and the driving wall, each against a solution known exactly or to high accuracy.

Some measurements march the heat operator alone, at frozen density; the others the whole method. Orders are those
between the two finest grids or smallest steps.
"""

from __future__ import annotations

import itertools
import math
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from hydro.driver.march import march
from hydro.dynamics.godunov import heat
from hydro.exact import (
    LinearMode,
    cell_averages,
    conduction_mode_decay,
    homogeneous_cooling,
    linear_modes,
)
from hydro.gas import Grossman
from hydro.mesh import Mesh
from hydro.methods import compiled_methods
from hydro.state import State
from hydro.studies.orders import orders
from hydro.terms import Friction
from hydro.verification.claims import Claim, Findings, Row, Table, at_least, at_most, measurement
from hydro.verification.setups import ELASTIC, IDEAL, along, godunov, l1, laid
from hydro.walls import ThermalWall, VibratingWall
from hydro.walls.boundary import Boundary

TOPIC = "Heat, friction and the driving wall"
GRANULAR = Grossman(L=5e4, K=2e-3)
SECOND, WALL_ORDER = 1.9, 1.8


class HeatOnly:
    """The heat operator alone, as an integrator: the flow stands still and the density is frozen."""

    def __init__(self, mesh: Mesh, gas: Any, wall: Any = ELASTIC):
        self.boundary = Boundary(gas, wall, mesh)
        self._heat = heat.Heat(gas, self.boundary, mesh, 1)

    def advance(self, state: State, end: float, steps: int) -> State:
        """Advance `state` in place to `end` in equal steps."""
        dt = (end - state.time) / steps
        for _ in range(steps):
            self._heat.advance(state.conserved, dt)
        state.time = end
        return state


@measurement(TOPIC, "Homogeneous cooling")
def cooling(full: bool) -> Findings:
    """A uniform gas at rest between elastic walls follows T0/(1 + t/t_c)^2 (Haff's law).

    L = 5e4, K = 2e-3, T0 = 1, default time step, to t = 20: largest relative error of T at the end, and of the
    density, which must not move.
    """
    claims: list[Claim] = []
    for n, cells in itertools.product((0.0235, 0.5), (16, 32)):
        mesh = Mesh.rectangle((cells, cells))
        state = State.of(GRANULAR, mesh, n, 1.0)
        march(state, godunov(mesh, GRANULAR), 20.0)
        error = np.max(np.abs(state.temperature / homogeneous_cooling(GRANULAR, n, 1.0, 20.0) - 1.0))
        name = f"cooling, n = {n}, {cells} x {cells} cells: relative error of T at t = 20"
        claims.append(at_most(TOPIC, name, "0", float(error), 1e-6))
    return Findings(tuple(claims)) + cooling_order()


def cooling_order() -> Findings:
    """Error against a fixed time step, n = 0.5, to a third of the cooling time."""
    n, mesh = 0.5, Mesh.rectangle((4, 4))
    end = 0.3 * 2.0 * n / float(GRANULAR.cooling_coefficient(n))
    counts = (16, 32, 64)
    errors = []
    for count in counts:
        state = HeatOnly(mesh, GRANULAR).advance(State.of(GRANULAR, mesh, n, 1.0), end, count)
        errors.append(float(np.max(np.abs(state.temperature / homogeneous_cooling(GRANULAR, n, 1.0, end) - 1.0))))
    steps = [end / count for count in counts]
    order = orders(steps, errors)[-1]
    table = Table("Cooling with fixed steps, n = 0.5.", ("dt", "relative error"), list(zip(steps, errors, strict=True)))
    return Findings((at_least(TOPIC, "cooling: order in dt", "3", order, 2.9),), (table,))


CONDUCTING = Grossman(L=0.0, K=0.1)
MODE_DENSITY = 0.2


def conduction_mode(mesh: Mesh) -> State:
    """Uniform density, and a cosine of temperature whose amplitude is small enough to be linear."""
    line = cell_averages(lambda x: np.cos(np.pi * x), mesh.x_faces)
    return State.of(CONDUCTING, mesh, MODE_DENSITY, 1.0 + 1e-6 * line[:, None])


def conduction_errors(cells: tuple[int, ...], stretch: float, steps: int) -> list[float]:
    """L1 errors of T over the amplitude, when the mode has decayed to about a third."""
    rate = float(conduction_mode_decay(CONDUCTING, MODE_DENSITY, 1.0, math.pi))
    errors = []
    for count in cells:
        mesh = Mesh.rectangle((count, 2), stretch=stretch)
        start = conduction_mode(mesh)
        wanted = 1.0 + math.exp(-1.0) * (start.temperature - 1.0)
        state = HeatOnly(mesh, CONDUCTING).advance(start, 1.0 / rate, steps)
        errors.append(l1(mesh, state.temperature - wanted) / 1e-6)
    return errors


@measurement(TOPIC, "Conduction")
def conduction(full: bool) -> Findings:
    """A small cosine of temperature at frozen density decays as exp(-kappa k^2 t/n); L = 0, elastic walls.

    Order in space with 400 steps, on a uniform mesh and on one whose widths grow fourfold; order in time from the
    differences between halved steps on 32 cells.
    """
    cells = (16, 32, 64, 128) if full else (16, 32, 64)
    claims: list[Claim] = []
    rows: list[Row] = []
    for stretch in (1.0, 4.0):
        errors = conduction_errors(cells, stretch, 400)
        order = orders([1.0 / count for count in cells], errors)[-1]
        rows.append((stretch, *errors, order))
        claims.append(at_least(TOPIC, f"conduction, stretch {stretch:g}: order in space", "2", order, SECOND))
    space = Table("L1 error over the amplitude.", ("stretch", *(f"{count} cells" for count in cells), "order"), rows)
    time, order = conduction_in_time()
    claims.append(at_least(TOPIC, "conduction: order in time", "2", order, SECOND))
    return Findings(tuple(claims), (space, time))


def conduction_in_time() -> tuple[Table, float]:
    """Differences between successive halvings of dt, and their order."""
    rate = float(conduction_mode_decay(CONDUCTING, MODE_DENSITY, 1.0, math.pi))
    mesh, counts = Mesh.rectangle((32, 2)), (8, 16, 32, 64)
    ends = [HeatOnly(mesh, CONDUCTING).advance(conduction_mode(mesh), 1.0 / rate, count) for count in counts]
    changes = [l1(mesh, coarse.temperature - fine.temperature) / 1e-6 for coarse, fine in itertools.pairwise(ends)]
    rows = list(zip(counts[:-1], changes, strict=True))
    table = Table("Change of T over the amplitude when dt is halved.", ("steps", "change"), rows)
    return table, orders([1.0 / count for count in counts[:-1]], changes)[-1]


MODE_AMPLITUDE = 1e-7  # small: a wave of finite amplitude steepens


@measurement(TOPIC, "Modes of the whole system")
def modes(full: bool) -> Findings:
    """Sound and heat modes of the linearised equations with conduction and friction (L = 0, K = 0.02, tau = 5).

    n = 0.3, T = 1, one wave in a periodic box, relative amplitude 1e-7, up to t = 0.4: L1 error of the density
    over the amplitude, against the eigenvectors of the exact 3 x 3 matrix. All parts of the method act together.
    """
    gas, n, tau, k = Grossman(L=0.0, K=0.02), 0.3, 5.0, 2.0 * math.pi
    cells = (32, 64, 128, 256) if full else (32, 64, 128)
    every = linear_modes(gas, n, 1.0, tau, k)
    claims: list[Claim] = []
    rows: list[Row] = []
    for name, riemann in itertools.product(("heat", "sound"), ("hllc", "hllc_lm")):
        mode = every[name]
        errors = [mode_error(gas, n, tau, mode, count, riemann) for count in cells]
        order = orders([1.0 / count for count in cells], errors)[-1]
        rows.append((f"{name}, s = {mode.rate:.3f}", riemann, *errors, order))
        claims.append(at_least(TOPIC, f"{name} mode, {riemann}: order", "2", order, SECOND))
    header = ("mode", "Riemann solver", *(f"{count} cells" for count in cells), "order")
    return Findings(tuple(claims), (Table("L1 error of the density over the amplitude.", header, rows),))


def mode_error(gas: Grossman, n: float, tau: float, mode: LinearMode, count: int, riemann: str) -> float:
    """L1 error of the density over its amplitude at t = 0.4."""
    mesh = along(0, count)

    def fields(t: float) -> np.ndarray:
        return laid(0, MODE_AMPLITUDE * cell_averages(lambda x: mode.fields(x, t), mesh.x_faces))

    dn, du, _, dT = fields(0.0)
    state = State.of(gas, mesh, n + dn, 1.0 + dT, (du, 0.0))
    march(state, godunov(mesh, gas, terms=[Friction(tau)], riemann=riemann), 0.4)
    return l1(mesh, state.density - n - fields(0.4)[0]) / MODE_AMPLITUDE


@measurement(TOPIC, "Rolling friction")
def friction(full: bool) -> Findings:
    """A uniform flow in a periodic box slows down as exp(-t/tau); its temperature stays."""
    mesh, tau = Mesh.rectangle((8, 8), periodic=(True, True)), 3.0
    state = State.of(IDEAL, mesh, 0.2, 1.0, (0.3, -0.2))
    march(state, godunov(mesh, terms=[Friction(tau)]), 5.0)
    u, v = state.velocity
    keep = math.exp(-5.0 / tau)
    error = max(float(np.max(np.abs(u / (0.3 * keep) - 1.0))), float(np.max(np.abs(v / (-0.2 * keep) - 1.0))))
    warming = float(np.max(np.abs(state.temperature - 1.0)))
    return Findings((
        at_most(TOPIC, "friction: relative error of the velocity at t = 5, tau = 3", "round-off", error, 1e-12),
        at_most(TOPIC, "friction: change of the temperature", "round-off", warming, 1e-12),
    ))  # fmt: skip


@compiled_methods
class CellValueWall(NamedTuple):
    """The vibrating wall with density and temperature of the last cell in place of those at the face."""

    strength: float

    def face(self, gas, n, T, half_width, guess):
        """(heat flux into the gas, wall temperature), as for the walls of the solver."""
        return self.strength * n * np.sqrt(T), T


class Extended(NamedTuple):
    """The y-independent steady state at pressure p: functions of x, and the wall that drives it."""

    density: Any
    temperature: Any
    strength: float


def extended_state(gas: Any, n0: float, p: float) -> Extended:
    """Integrate d(kappa T')/dx = I at uniform pressure from the density n0 at x = 0, to ten digits and more."""

    def slopes(x, y):
        T, flux = y
        n = gas.density(p, T)
        return [flux / gas.conductivity(n, T), gas.cooling(n, T)]

    start = [gas.temperature(n0, p), 0.0]
    solution = solve_ivp(slopes, (0.0, 1.0), start, method="DOP853", rtol=1e-13, atol=1e-16, dense_output=True)

    def temperature(x):
        x = np.asarray(x)
        return solution.sol(x.ravel())[0].reshape(x.shape)

    T, flux = solution.y[:, -1]
    strength = flux / (gas.density(p, T) * math.sqrt(T))
    return Extended(lambda x: gas.density(p, temperature(x)), temperature, float(strength))


class WallErrors(NamedTuple):
    """Relative errors of the steady state: temperature and density at the wall, and of T over the box."""

    temperature: float
    density: float
    field: float


def wall_errors(wall: Any, exact: Extended, count: int) -> WallErrors:
    """March the temperature to steadiness at the exact density, averaged over cells."""
    mesh = Mesh.rectangle((count, 1))
    n = cell_averages(exact.density, mesh.x_faces)[:, None]
    T = cell_averages(exact.temperature, mesh.x_faces)[:, None]
    state = State.of(DRIVEN, mesh, n, 0.8 * T)
    method = HeatOnly(mesh, DRIVEN, wall)
    method.advance(state, STEADY, 4)
    (T_wall,) = method.boundary.temperatures()["wall_temperature_x1"]
    last_n, last_T = state.density[-1, 0], state.temperature[-1, 0]
    _, T_wall = wall.face(DRIVEN, last_n, last_T, 0.5 * mesh.dx[-1], T_wall)
    n_wall = DRIVEN.density(DRIVEN.pressure(last_n, last_T), T_wall)
    return WallErrors(
        abs(float(T_wall / exact.temperature(1.0)) - 1.0),
        abs(float(n_wall / exact.density(1.0)) - 1.0),
        l1(mesh, state.temperature / T - 1.0),
    )


DRIVEN = Grossman(L=5e3, K=0.1)
STEADY = 1.0  # some twenty times the slowest decay time
WALL_CELLS = (16, 32, 64)


def wall_convergence(names: dict[str, Any], exact: Extended) -> Findings:
    """Errors and orders for walls by name; orders are claimed of those that the solver offers."""
    claims: list[Claim] = []
    rows: list[Row] = []
    for name, wall in names.items():
        errors = [wall_errors(wall, exact, count) for count in WALL_CELLS]
        for what in WallErrors._fields:
            series = [getattr(error, what) for error in errors]
            exactly = max(series) < 1e-12  # the temperature of a thermal wall
            order = math.inf if exactly else orders([1.0 / count for count in WALL_CELLS], series)[-1]
            rows.append((name, what, *series, order))
            if name in ("vibrating", "thermal"):
                claims.append(at_least(TOPIC, f"{name} wall, error of {what}: order", "2", order, WALL_ORDER))
    header = ("wall", "error of", *(f"{count} cells" for count in WALL_CELLS), "order")
    return Findings(tuple(claims), (Table("Relative errors of the steady state.", header, rows),))


@measurement(TOPIC, "Vibrating wall")
def vibrating_wall(full: bool) -> Findings:
    """Steady conduction with cooling between an elastic and a vibrating wall, L = 5e3, n = 0.2 at x = 0.

    The exact state is integrated from its ordinary differential equation. Its density, averaged over cells, is
    frozen, and the temperature is marched from 0.8 of the exact one until nothing changes. In the full version
    also, for comparison, a wall law that takes the values of the last cell instead of those at the face.
    """
    exact = extended_state(DRIVEN, 0.2, 0.3)
    walls: dict[str, Any] = {"vibrating": VibratingWall(exact.strength)}
    if full:
        walls["values of the last cell"] = CellValueWall(exact.strength)
    return wall_convergence(walls, exact)


@measurement(TOPIC, "Thermal wall")
def thermal_wall(full: bool) -> Findings:
    """The same steady state, held by a wall of its temperature; that temperature itself is then exact."""
    exact = extended_state(DRIVEN, 0.2, 0.3)
    return wall_convergence({"thermal": ThermalWall(float(exact.temperature(1.0)))}, exact)
