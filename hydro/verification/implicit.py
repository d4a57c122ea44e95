"""The implicit integrator `lagrange-remap`: orders, shocks, books, and Fig. 4 against its own tolerance and `godunov`.

That localized states are its fixed points is measured with those of the other integrators, below.
"""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np

from hydro.driver.march import Run, march
from hydro.driver.trackers import AtTimes
from hydro.dynamics.integrator import Integrator
from hydro.dynamics.lagrange import LagrangeRemap
from hydro.gas import Grossman
from hydro.initial.cosine import cosine_averages
from hydro.mesh import Mesh
from hydro.observables.clustering import wall_extremes
from hydro.state import State
from hydro.steady.growth import growth_of, with_mode
from hydro.steady.localized import steady_state
from hydro.studies.orders import orders
from hydro.terms import Friction
from hydro.verification.claims import Claim, Findings, Row, Table, at_least, at_most, measurement
from hydro.verification.riemann_problems import HARD, PROBLEMS, calculate, random_problems
from hydro.verification.setups import ELASTIC, IDEAL, FixedSteps, along, godunov, l1
from hydro.verification.waves import along_a_line, simple_wave
from hydro.walls import VibratingWall

TOPIC = "The implicit integrator"
GAS, WALL, TAU = Grossman(L=5e4, K=2e-3), VibratingWall(strength=0.228), 200.0
F, DELTA = 0.0235, 2.0
TIMES = (100.0, 500.0, 1000.0, 1290.0)
DEFAULT = 3e-4  # tolerance
OVERSHOOT = 0.02  # of the jump, of shocks


def implicit(mesh: Mesh, gas: Any = IDEAL, wall: Any = ELASTIC, **options: Any) -> LagrangeRemap:
    """The integrator, of ideal flow between elastic walls unless told otherwise."""
    return LagrangeRemap(gas, wall, mesh, **options)


def driven(mesh: Mesh, **options: Any) -> LagrangeRemap:
    """The integrator with the gas, wall and friction of Fig. 4."""
    return implicit(mesh, GAS, WALL, terms=[Friction(TAU)], **options)


def start_of_fig4(cells: int) -> State:
    """The initial state of Fig. 4, on `cells` by twice as many cells."""
    return start(cells, DELTA, 2)


def evolve(integrator: Integrator, state: State, times: tuple[float, ...]) -> tuple[list[float], dict[str, float]]:
    """Largest and smallest wall densities at the times, in turn, and the energies exchanged up to the last."""
    seen: list[float] = []

    def watch(run: Run) -> None:
        low, high = wall_extremes(state.density, state.mesh)
        seen.extend((high, low))

    return seen, march(state, integrator, times[-1], [AtTimes(watch, times)]).ledger.amounts


@measurement(TOPIC, "Order in time")
def order_in_time(full: bool) -> Findings:
    """Differences between fixed steps dt, dt/2, dt/4, dt/8: a simple wave, and the start of Fig. 4 with all terms on.

    Simple wave on 64 cells, to a quarter of its breaking time, steps from a fifth of a cell's sound crossing time;
    Fig. 4 on 16 x 32 cells from t = 0.2, when the wall's first heat has spread, to 2.2, steps from 0.04.
    """
    wave, fig4 = wave_differences(), fig4_differences()
    rows: list[Row] = [("simple wave", *wave), ("Fig. 4", *fig4)]
    steps = [1.0, 0.5, 0.25]
    claims = tuple(
        at_least(TOPIC, f"{name}: order in time", "2", orders(steps, differences)[-1], 1.9)
        for name, differences in (("simple wave", wave), ("Fig. 4", fig4))
    )
    header = ("case", "dt to dt/2", "dt/2 to dt/4", "dt/4 to dt/8")
    return Findings(claims, (Table("Mean differences of the density.", header, rows),))


def wave_differences() -> list[float]:
    """Mean differences of n between steps and their halves, for the simple wave."""
    mesh, end = along(0, 64, thickness=2), 0.25 * simple_wave().breaking_time
    results = []
    for count in (160, 320, 640, 1280):
        state = State(IDEAL, mesh, exact_wave(mesh, 0.0))
        march(state, FixedSteps(implicit(mesh, tolerance=math.inf), end / count), end)
        results.append(state.density)
    return [l1(mesh, after - before) for before, after in itertools.pairwise(results)]


def exact_wave(mesh: Mesh, t: float) -> np.ndarray:
    """The simple wave along x on a mesh that is two cells thick."""
    line = along_a_line(along(0, mesh.cells[0]), t)
    return np.repeat(line, mesh.cells[1], axis=2)


def fig4_differences() -> list[float]:
    """Mean differences of n between steps and their halves, for the start of Fig. 4."""
    first = start_of_fig4(16)
    march(first, driven(first.mesh), 0.2)
    results = []
    for count in (50, 100, 200, 400):
        state = first.copy()
        march(state, FixedSteps(driven(state.mesh, tolerance=math.inf), 2.0 / count), 2.2)
        results.append(state.density)
    return [l1(first.mesh, after - before) for before, after in itertools.pairwise(results)]


@measurement(TOPIC, "Order in space, sound and shocks")
def sound_and_shocks(full: bool) -> Findings:
    """A simple wave with steps in proportion to the cells, and Riemann problems with a small tolerance.

    It is a compressible code: shocks have the right speed. Artificial viscosity keeps them from ringing.
    """
    grids = (32, 64, 128, 256) if full else (32, 64, 128)
    errors = []
    for cells in grids:
        mesh, end = along(0, cells, thickness=2), 0.5 * simple_wave().breaking_time
        state = State(IDEAL, mesh, exact_wave(mesh, 0.0))
        march(state, FixedSteps(implicit(mesh, tolerance=math.inf), end / (5 * cells)), end)
        errors.append(l1(mesh, state.density - exact_wave(mesh, end)[0]))
    rows: list[Row] = [("simple wave", *map(float, errors), "")]
    claims: list[Claim] = [
        at_least(TOPIC, "simple wave: order", "2", orders([1.0 / cells for cells in grids], errors)[-1], 1.9)
    ]
    for problem in PROBLEMS[:2]:
        outcomes = [calculate(problem, 0, cells, implicit, tolerance=1e-3) for cells in (100, 200, 400)]
        of_all, at_shock = ([getattr(o, name) for o in outcomes] for name in ("error", "shock_error"))
        rows.append((problem.name, *of_all, outcomes[-1].overshoot))
        sizes = [1.0 / 100, 1.0 / 200, 1.0 / 400]
        claims.append(at_least(TOPIC, f"{problem.name}: order of the L1 error", "1", orders(sizes, of_all)[-1], 0.6))
        claims.append(at_least(TOPIC, f"{problem.name}: order at the shock", "1", orders(sizes, at_shock)[-1], 0.8))
    header = ("case", *(f"grid {number + 1}" for number in range(len(grids))), "overshoot over the jump")
    padded = [(*row[:-1], *[""] * (len(header) - len(row)), row[-1]) for row in rows]
    return Findings(tuple(claims), (Table("L1 errors of the density.", header, padded),))


@measurement(TOPIC, "Hard shocks")
def hard_shocks(full: bool) -> Findings:
    """Problems at which this integrator once stalled or rang, and 12 random ones (4 in the short version).

    The latter: log n uniform from 1e-4 to 0.85, u from -2 to 2, log T from 0.1 to 10.

    All by default settings, beside `godunov`. An overshoot is claimed where the exact solution can be seen on the mesh:
    thin gas that dense gas pushes is compressed within a few cells, and there both integrators keep the error of the
    first steps. A run that stalls fails them all.
    """
    cells = 400 if full else 200
    claims: list[Claim] = []
    rows: list[Row] = []
    for problem in [*HARD, *random_problems(12 if full else 4)]:
        explicit_one, outcome = calculate(problem, 0, cells), calculate(problem, 0, cells, implicit)
        rows.append((
            problem.name, *(f"{value:.3g}" for value in (*problem.left, *problem.right)),
            explicit_one.error, outcome.error, f"{explicit_one.overshoot:.4f}", f"{outcome.overshoot:.4f}",
        ))  # fmt: skip
        ratio = outcome.error / explicit_one.error
        claims.append(at_most(TOPIC, f"{problem.name}: L1 error over that of godunov", "1", ratio, 2.0))
        if explicit_one.overshoot < OVERSHOOT:
            name = f"{problem.name}: overshoot over the jump"
            claims.append(at_most(TOPIC, name, "0 for a monotone method", outcome.overshoot, OVERSHOOT))
    sides = ("n", "u", "p", "n", "u", "p")
    header = ("problem", *sides, "L1, godunov", "L1", "overshoot, godunov", "overshoot")
    return Findings(tuple(claims), (Table(f"Riemann problems on {cells} cells.", header, rows),))


@measurement(TOPIC, "Fig. 4: tolerance, books, symmetry")
def fig4(full: bool) -> Findings:
    """The eight numbers of Fig. 4 at the default tolerance and at a quarter of it; mass, energy and mirror symmetry."""
    cells = 32 if full else 16
    rows: list[Row] = []
    numbers = []
    claims: list[Claim] = []
    for tolerance in (DEFAULT, DEFAULT / 4.0):
        state = start_of_fig4(cells)
        mass, energy = state.mass, state.energy
        seen, given = evolve(driven(state.mesh, tolerance=tolerance), state, TIMES)
        numbers.append(np.array(seen))
        rows.append((f"{tolerance:g}", *(f"{value:.4f}" for value in seen)))
        missing = state.energy - energy - given["wall"] + given["collisions"] + given["friction"]
        mirror = float(np.max(np.abs(state.density / state.density[:, ::-1] - 1.0)))
        name = f"tolerance {tolerance:g}"
        claims += [
            at_most(TOPIC, f"{name}: drift of the mass", "round-off", abs(state.mass / mass - 1.0), 1e-12),
            at_most(TOPIC, f"{name}: residual of the energy's books", "round-off", abs(missing) / given["wall"], 1e-10),
            at_most(TOPIC, f"{name}: mirror symmetry of n", "exact", mirror, 1e-14),
        ]
    change = float(np.max(np.abs(numbers[0] / numbers[1] - 1.0)))
    claims.append(at_most(TOPIC, "Fig. 4: change by a quarter of the tolerance", "0", change, 0.01))
    header = ("tolerance", *(f"{what}, t = {time:g}" for time in TIMES for what in ("max", "min")))
    return Findings(tuple(claims), (Table(f"Fig. 4 on {cells} x {2 * cells} cells.", header, rows),))


@measurement(TOPIC, "Fig. 4 by both integrators")
def both(full: bool) -> Findings:
    """Wall densities of Fig. 4 at t = 100 (and 500 in the full book), by `lagrange-remap` at a tolerance of 1e-4, and
    by `godunov`: the difference has to shrink with the grid.
    """
    grids, times = ((16, 32, 48), (100.0, 500.0)) if full else ((12, 24), (100.0,))
    rows: list[Row] = []
    differences = []
    for cells in grids:
        numbers = []
        for integrator in (driven(start_of_fig4(cells).mesh, tolerance=1e-4), explicit(cells)):
            seen, _ = evolve(integrator, start_of_fig4(cells), times)
            numbers.append(np.array(seen))
            rows.append((cells, type(integrator).__name__, *(f"{value:.4f}" for value in seen)))
        differences.append(float(np.max(np.abs(numbers[0] / numbers[1] - 1.0))))
    gain = differences[0] / differences[-1]
    claims = (
        at_most(TOPIC, f"largest relative difference on {grids[-1]} cells", "0", differences[-1], 0.05),
        at_least(TOPIC, f"gain from {grids[0]} to {grids[-1]} cells", "4 a doubling", gain, grids[-1] / grids[0]),
    )
    header = ("cells in x", "integrator", *(f"{what}, t = {time:g}" for time in times for what in ("max", "min")))
    return Findings(claims, (Table("Wall densities.", header, rows),))


def explicit(cells: int) -> Integrator:
    """The explicit integrator for Fig. 4."""
    return godunov(start_of_fig4(cells).mesh, GAS, WALL, terms=[Friction(TAU)])


@measurement(TOPIC, "It ends in the states of the Newton solver")
def ends(full: bool) -> Findings:
    """From exactly symmetric starts, aspect ratios 1, 2 and 3: n at the end against the steady state on the same mesh.

    Starts are cosines, as in Fig. 4; densities are compared at t = 5000, with the mirror image where the cluster has
    gone to the other corner. Two clusters (Fig. 4) are unstable to exchange of mass, but the start is its own mirror
    image, and remains so to round-off. A chain of three half-waves is unstable too, and no symmetry of the box keeps
    it: that run is shown for what it leaves the chain for.
    """
    starts = ((1.0, 1), (2.0, 2), (3.0, 1), (3.0, 3)) if full else ((1.0, 1), (2.0, 2))
    rows: list[Row] = []
    claims = []
    for aspect_ratio, wave in starts:
        state = start(16, aspect_ratio, wave)
        steady = steady_state(GAS, WALL, state.mesh, F, wave)
        settle(driven(state.mesh), state, 5000.0)
        error = distance(state, steady.state)
        growth = max(mode.growth_rate.real for sector in growth_of(steady, TAU, 1) for mode in sector.modes)
        low, high = wall_extremes(state.density, state.mesh)
        rows.append((aspect_ratio, wave, f"{growth:.4f}", f"{high:.4f}", f"{low:.4f}", f"{error:.1e}"))
        if wave < 3:
            name = f"aspect ratio {aspect_ratio:g}, {wave} half-waves: relative distance from the steady state"
            claims.append(at_most(TOPIC, name, "0", error, 1e-8))
    header = (
        "aspect ratio",
        "half-waves",
        "largest growth rate of the steady state",
        "wall max",
        "wall min",
        "distance",
    )
    return Findings(tuple(claims), (Table("Runs on 16 cells per unit length, at t = 5000.", header, rows),))


def start(cells: int, aspect_ratio: float, wave: int) -> State:
    """A cosine with `wave` half-waves, as in Fig. 4, on `cells` cells per unit length."""
    mesh = Mesh.rectangle((cells, round(cells * aspect_ratio)), aspect_ratio)
    return State.of(GAS, mesh, F * (1.0 + 0.1 * cosine_averages(mesh, wave)), 1.0)


def settle(integrator: Integrator, state: State, end: float) -> None:
    """Run to `end`, ending a step every 250 time units: at rest steps grow, and the longest damp the least."""
    march(state, integrator, end, [AtTimes(lambda run: None, every=250.0)])


def distance(state: State, steady: State) -> float:
    """Largest relative difference of n from a steady state or its mirror image, the smaller of the two."""
    images = (steady.density, steady.density[:, ::-1])
    return min(float(np.max(np.abs(state.density / image - 1.0))) for image in images)


@measurement(TOPIC, "Exchange of mass between two clusters")
def exchange(full: bool) -> Findings:
    """The antisymmetric mode of the full-wave state grows in runs of this integrator at the rate of its eigenvalue.

    One cluster then eats the other: at t = 16000 the gas is in the half-wave state of the same box.
    """
    cells = 32
    mesh = Mesh.rectangle((cells, 2 * cells), DELTA)
    steady = steady_state(GAS, WALL, mesh, F, 2)
    mode = next(growth for growth in growth_of(steady, TAU, 1) if growth.sector == "antisymmetric").modes[0]
    state = with_mode(steady.state, mode, 1e-4)
    integrator = driven(mesh)
    shares = []
    for time in (50.0, 500.0):
        march(state, integrator, time)
        shares.append(mesh.integral((state.density - steady.state.density) * mode.density.real))
    rate = math.log(shares[1] / shares[0]) / 450.0
    error = abs(rate / mode.growth_rate.real - 1.0)
    settle(integrator, state, 16000.0)
    apart = distance(state, steady_state(GAS, WALL, mesh, F, 1).state)
    low, high = wall_extremes(state.density, mesh)
    rows: list[Row] = [(f"{mode.growth_rate.real:.6f}", f"{rate:.6f}", f"{high:.4f}", f"{low:.5f}")]
    table = Table("On 32 x 64 cells.", ("eigenvalue", "growth rate", "wall max at the end", "wall min"), rows)
    claims = (
        at_most(TOPIC, "growth rate, relative difference", "0", error, 0.01),
        at_most(TOPIC, "at the end: relative distance from the half-wave state", "0", apart, 1e-8),
    )
    return Findings(claims, (table,))
