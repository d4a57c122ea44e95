"""Localized states against the evolution code, against each other on finer meshes, and against full spectra.

Unless said otherwise: L = 5e4, f = 0.0235, K = 2e-3, tau = 200, vibrating wall with W = 114. A growth rate is an
eigenvalue of the linearized time-dependent equations; the same rate is measured in runs of the evolution code that
start from the steady state plus a small eigenmode. Neither method knows of the other.
"""

from __future__ import annotations

import itertools
import math
from typing import Any, NamedTuple

import numpy as np

from hydro.choices import INTEGRATORS
from hydro.driver.march import march
from hydro.gas import Grossman
from hydro.mesh import Mesh
from hydro.observables.clustering import wall_extremes
from hydro.state import State
from hydro.steady.balance import Balance
from hydro.steady.bifurcation import ExtendedBranch
from hydro.steady.continuation import Family, Point, fold_between, follow
from hydro.steady.extended import extended_state
from hydro.steady.growth import growth_of, lower_half, with_mode
from hydro.steady.localized import extended_solution, steady_state
from hydro.steady.marginal import critical_aspect_ratio
from hydro.steady.spectrum import Linearization, Mode, even, odd
from hydro.studies.orders import orders
from hydro.terms import Friction
from hydro.verification.claims import Claim, Findings, Row, Table, at_least, at_most, measurement
from hydro.walls import ThermalWall, VibratingWall

TOPIC = "Localized steady states, growth rates and branches"
GAS, TAU, F = Grossman(L=5e4, K=2e-3), 200.0, 0.0235
VIBRATING, THERMAL = VibratingWall(strength=GAS.K * 114.0), ThermalWall(1.0)


def state_of(wave: int, cells: tuple[int, int], wall: Any = VIBRATING, stretch: float = 1.0, f: float = F):
    """A steady state with half-waves of width one; the extended state (wave 0) in a box of aspect ratio one."""
    mesh = Mesh.rectangle(cells, float(max(wave, 1)), stretch)
    return steady_state(GAS, wall, mesh, f, wave)


FIXED_POINTS = {
    "one cluster, vibrating wall": (1, VIBRATING, 1.0),
    "one cluster, thermal wall": (1, THERMAL, 1.0),
    "one cluster, stretched mesh": (1, VIBRATING, 4.0),
    "two clusters": (2, VIBRATING, 1.0),
    "extended state": (0, VIBRATING, 1.0),
}


@measurement(TOPIC, "Steady states are fixed points of the evolution")
def fixed_points(full: bool) -> Findings:
    """Largest relative change of n in 100 time units, for every integrator, from Newton's solution on the same mesh.

    16 x 16 cells per half-wave (32 x 32 in the full book). States which are unstable leave at their growth rate, but
    from the round-off of the start.
    """
    cells = 32 if full else 16
    claims = []
    for (name, (wave, wall, stretch)), integrator in itertools.product(FIXED_POINTS.items(), INTEGRATORS):
        steady = state_of(wave, (cells, cells * max(wave, 1)), wall, stretch)
        state = steady.state
        march(state, INTEGRATORS[integrator](GAS, wall, state.mesh, terms=[Friction(TAU)]), 100.0)
        moved = float(np.max(np.abs(state.density / steady.state.density - 1.0)))
        claims.append(at_most(TOPIC, f"{name}, {integrator}: relative change of n in 100 units", "0", moved, 1e-9))
    return Findings(tuple(claims))


@measurement(TOPIC, "What the mesh and the wall do to the densities")
def densities(full: bool) -> Findings:
    """The state of Fig. 3a on finer and finer meshes; other driving strengths; the extended state for both walls.

    The order is that of the smallest density on the wall x = 0, and of the density itself in the L1 norm against the
    next finer mesh. The largest density converges faster on these meshes: its second-order error happens to be small.
    """
    grids = (32, 64, 128, 256, 512) if full else (16, 32, 64, 128)
    states = [state_of(1, (cells, cells)).state for cells in grids]
    low, high = np.array([wall_extremes(state.density, state.mesh) for state in states]).T
    changes = [coarse_change(before, after) for before, after in itertools.pairwise(states)]
    order_low = math.log2(abs((low[-2] - low[-3]) / (low[-1] - low[-2])))
    limit_high, limit_low = high[-1] + (high[-1] - high[-2]) / 3.0, low[-1] + (low[-1] - low[-2]) / 3.0
    rows: list[Row] = [(f"{n} x {n}", f"{b:.6f}", f"{a:.6f}") for n, a, b in zip(grids, low, high, strict=True)]
    rows.append(("limit", f"{limit_high:.6f}", f"{limit_low:.6f}"))
    table = Table("Fig. 3a: densities on the wall x = 0.", ("cells", "largest", "smallest"), rows)
    l1_order = orders([1.0 / cells for cells in grids[:-1]], changes)[-1]
    quarter = VibratingWall(strength=0.25 * VIBRATING.strength)
    weak = state_of(1, (32, 32), quarter).state.density / state_of(1, (32, 32)).state.density
    walls = [extended_solution(Balance.of(GAS, wall, Mesh.rectangle((64, 1)), F)) for wall in (VIBRATING, THERMAL)]
    between = float(np.max(np.abs(np.expm1(walls[0].unknowns[:-1] - walls[1].unknowns[:-1]))))
    claims = (
        at_least(TOPIC, "order of the smallest wall density", "2", order_low, 1.9),
        at_least(TOPIC, "order of the density, L1", "2", l1_order, 1.9),
        at_most(TOPIC, "largest wall density, limit, against the paper's 0.76", "0", abs(limit_high - 0.76), 5e-3),
        at_most(TOPIC, "smallest wall density, limit, against 0.036", "0", abs(limit_low - 0.036), 5e-4),
        at_most(TOPIC, "relative error left in the largest (last change)", "0", abs(high[-1] / high[-2] - 1.0), 1e-3)
        if full
        else at_most(TOPIC, "last relative change of the largest", "0", abs(high[-1] / high[-2] - 1.0), 5e-3),
        at_most(TOPIC, "n for W = 28.5 against 114, relative", "0", float(np.max(np.abs(weak - 1.0))), 1e-9),
        at_most(TOPIC, "extended state, thermal against vibrating, relative in 1/n - 1", "0", between, 1e-9),
    )
    return Findings(claims, (table,))


def coarse_change(coarse: State, fine: State) -> float:
    """Mean |n| difference between a state and the averages over its cells of the state on twice as many."""
    nx, ny = coarse.mesh.cells
    averages = fine.density.reshape(nx, 2, ny, 2).mean(axis=(1, 3))
    return coarse.mesh.integral(np.abs(averages - coarse.density))


class GrowthCase(NamedTuple):
    """A steady state and the mode put on it; the rate is measured between the two times."""

    wave: int
    sector: str
    start: float
    end: float


GROWTH_CASES = {
    "extended state, half-wave": GrowthCase(0, "1 half-wave", 10.0, 60.0),
    "one cluster, leading mode": GrowthCase(1, "all", 10.0, 60.0),
    "two clusters, exchange of mass": GrowthCase(2, "antisymmetric", 20.0, 100.0),
}


@measurement(TOPIC, "Growth rates, eigenvalue against evolution")
def growth_rates(full: bool) -> Findings:
    """The rate at which a small eigenmode grows or decays in a run of the evolution code, against its eigenvalue.

    Amplitude 1e-4 of the density; the deviation from the steady state is projected on the mode.
    """
    grids = (16, 32, 64) if full else (16, 32)
    rows: list[Row] = []
    claims: list[Claim] = []
    for name, case in GROWTH_CASES.items():
        errors = []
        for cells in grids:
            eigenvalue, measured = both_rates(case, cells)
            errors.append(abs(measured / eigenvalue - 1.0))
            rows.append((name, cells, f"{eigenvalue:.6f}", f"{measured:.6f}", errors[-1]))
        claims.append(at_most(TOPIC, f"{name}: relative difference, {grids[-1]} cells in x", "0", errors[-1], 0.01))
        gained = errors[0] / errors[-1]
        wanted = float(grids[-1] // grids[0])
        claims.append(at_least(TOPIC, f"{name}: gain from {grids[0]} to {grids[-1]} cells", "4 a grid", gained, wanted))
    header = ("mode", "cells in x", "eigenvalue", "measured", "relative difference")
    return Findings(tuple(claims), (Table("Growth rates per unit time.", header, rows),))


def both_rates(case: GrowthCase, cells: int) -> tuple[float, float]:
    """The growth rate as an eigenvalue, and as measured."""
    steady = state_of(case.wave, (cells, cells * max(case.wave, 1)))
    growth = next(growth for growth in growth_of(steady, TAU, 1) if growth.sector == case.sector)
    mode = growth.modes[0]
    state = with_mode(steady.state, mode, 1e-4)
    integrator = INTEGRATORS["godunov"](GAS, VIBRATING, state.mesh, terms=[Friction(TAU)])
    shares = []
    for time in (case.start, case.end):
        march(state, integrator, time)
        shares.append(state.mesh.integral((state.density - steady.state.density) * mode.density.real))
    return mode.growth_rate.real, math.log(shares[1] / shares[0]) / (case.end - case.start)


@measurement(TOPIC, "The whole spectrum on a coarse mesh")
def spectra(full: bool) -> Findings:
    """All eigenvalues of the linearized equations by dense algebra, 16 x 16 cells, against the few found by iteration.

    The rightmost of all (but for the zero of mass and the constant potential) must be the leading one that was found:
    no oscillation, sound included, grows faster or decays slower.
    """
    rows: list[Row] = []
    claims: list[Claim] = []
    for name, state, sector in spectrum_cases():
        linear = Linearization(state, VIBRATING, TAU, sector)
        dense = np.linalg.eigvals(linear.matrix.toarray())
        zero = np.argmin(np.abs(dense)) if not sector.leak.any() else None
        others = np.delete(dense, zero) if zero is not None else dense
        others = others[np.abs(others + 1.0 / TAU) > 1e-6 / TAU]
        rightmost = others[np.argmax(others.real)]
        sound = max((value.real for value in others if abs(value.imag) > 0.5), default=-math.inf)
        found = linear.leading()[0].growth_rate
        rows.append((name, f"{found.real:.6f}", f"{rightmost.real:.6f}", f"{sound:.4f}"))
        error = abs(found - rightmost) / abs(rightmost)
        claims.append(at_most(TOPIC, f"{name}: leading eigenvalue, relative difference", "0", error, 1e-6))
    header = ("state and sector", "found", "rightmost of all", "slowest decay of sound")
    return Findings(tuple(claims), (Table("Leading eigenvalues.", header, rows),))


def spectrum_cases():
    """(name, state, sector): one cluster, and two clusters for both symmetries."""
    one, two = state_of(1, (16, 16)).state, lower_half(state_of(2, (16, 32)).state)
    yield "one cluster, all", one, even(one.mesh)
    yield "two clusters, symmetric", two, even(two.mesh)
    yield "two clusters, antisymmetric", two, odd(two.mesh)


@measurement(TOPIC, "Two clusters exchange mass")
def exchange(full: bool) -> Findings:
    """The full-wave state at Delta = 2, f = 0.0235, the end of Fig. 4, which the paper calls dynamically stable.

    Growth rates with clusters in both corners, and with one cluster in the middle; finer and finer meshes. A positive
    antisymmetric rate means that one cluster feeds on the other (or moves to a corner), unless the start is a mirror
    image of itself to the last bit.
    """
    grids = (32, 64, 128) if full else (16, 32, 64)
    rows: list[Row] = []
    rates: dict[str, list[float]] = {"symmetric": [], "antisymmetric": []}
    for cells, shifted in itertools.product(grids, (False, True)):
        mesh = Mesh.rectangle((cells, 2 * cells), 2.0)
        steady = steady_state(GAS, VIBRATING, mesh, F, 2, shifted)
        growths = {growth.sector: growth.rate for growth in growth_of(steady, TAU, 1)}
        form = "in the middle" if shifted else "in both corners"
        rows.append((f"{cells} x {2 * cells}", form, *(f"{growths[sector]:.6f}" for sector in rates)))
        if not shifted:
            for sector in rates:
                rates[sector].append(growths[sector])
    order = math.log2(abs(np.diff(rates["antisymmetric"])[0] / np.diff(rates["antisymmetric"])[1]))
    claims = (
        at_least(
            TOPIC, "two clusters in the corners: antisymmetric growth rate", "1e-3", rates["antisymmetric"][-1], 0.0
        ),
        at_most(TOPIC, "two clusters in the corners: symmetric growth rate", "< 0", rates["symmetric"][-1], 0.0),
        at_least(TOPIC, "order of the antisymmetric rate in the mesh width", "2", order, 1.5),
    )
    header = ("cells", "clusters", "symmetric", "antisymmetric")
    return Findings(claims, (Table("Leading growth rates of the full-wave state.", header, rows),))


class BranchCase(NamedTuple):
    """A range of a parameter, at an aspect ratio, and what is expected there."""

    aspect_ratio: float
    parameter: str
    limits: tuple[float, float]
    expected: str  # kinds of bifurcation, in order of the parameter


BRANCH_CASES = {
    "Delta = 1, right": BranchCase(1.0, "f", (0.025, 0.031), "subcritical"),
    "Delta = 2": BranchCase(2.0, "f", (0.0095, 0.035), "supercritical, subcritical"),
    "Delta = 3": BranchCase(3.0, "f", (0.0075, 0.035), "supercritical, subcritical"),
    "f = 0.0235, from below in Delta": BranchCase(1.0, "aspect_ratio", (0.55, 0.9), "supercritical"),
}
FOLD_CASES = {  # aspect ratio, range of f, stretch of the mesh, known f of the fold
    "Delta = 1": (1.0, (0.0265, 0.034), 1.0, 0.0295),
    "Delta = 2": (2.0, (0.028, 0.07), 4.0, 0.06),
}


@measurement(TOPIC, "Bifurcations and folds")
def branches(full: bool) -> Findings:
    """How half-wave states leave the extended one: kinds of bifurcation, folds, hysteresis between them.

    A bifurcation is supercritical if the first states of its branch are stable. At the fold, found from the turn of the
    branch, the leading eigenvalue has to vanish: it is computed by other means. The dense branch of Delta = 2 is
    followed to its fold on cells four times narrower at the wall x = 0 than at the other.
    """
    rows: list[Row] = []
    claims: list[Claim] = []
    for name, case in BRANCH_CASES.items():
        for cells in (32, 64) if full else (32,):
            found = bifurcation_kinds(case, cells)
            kinds = ", ".join(kind for _, kind in found)
            rows.append((name, cells, ", ".join(f"{value:.6f}" for value, _ in found), kinds))
        claims.append(at_least(TOPIC, f"{name}: {case.expected}", "1 (yes)", float(kinds == case.expected), 1.0))
    table = Table("Bifurcations of the extended state.", ("box", "cells in x", "at", "kind"), rows)
    return Findings(tuple(claims), (table,)) + critical_values(full) + folds(full)


def critical_values(full: bool) -> Findings:
    """The bifurcation in the aspect ratio on finite volumes, against the marginal curve."""
    grids = (32, 64, 128) if full else (16, 32, 64)
    exact = critical_aspect_ratio(extended_state(GAS, F), "vibrating").aspect_ratio
    assert exact is not None
    rows: list[Row] = []
    errors = []
    for cells in grids:
        (found,) = ExtendedBranch(family_of(1.0, cells, "aspect_ratio")).bifurcations(np.geomspace(0.55, 0.9, 5))
        errors.append(abs(found.value / exact - 1.0))
        rows.append((cells, f"{found.value:.6f}", errors[-1]))
    rows.append(("marginal curve", f"{exact:.6f}", 0.0))
    order = orders([1.0 / cells for cells in grids], errors)[-1]
    claim = at_least(TOPIC, "critical aspect ratio, finite volumes against marginal curve: order", "2", order, 1.9)
    table = Table("Critical aspect ratio at f = 0.0235.", ("cells in x", "Delta_1", "relative difference"), rows)
    return Findings((claim,), (table,))


def folds(full: bool) -> Findings:
    """Where the branches turn back."""
    rows: list[Row] = []
    claims: list[Claim] = []
    for name, (aspect_ratio, limits, stretch, known) in FOLD_CASES.items():
        grids = (32, 64, 128) if full else (16, 32, 64)
        found = [fold_of(aspect_ratio, limits, stretch, cells) for cells in grids]
        values = [value for value, _, _ in found]
        rows += [
            (name, cells, f"{value:.6f}", f"{high:.5f}") for cells, (value, _, high) in zip(grids, found, strict=True)
        ]
        ratio = (values[1] - values[0]) / (values[2] - values[1])
        limit = values[2] + (values[2] - values[1]) / 3.0
        rows.append((name, "limit", f"{limit:.6f}", ""))
        claims += [
            at_most(TOPIC, f"{name}: leading eigenvalue at the fold", "0", abs(found[2][1]), 1e-6),
            at_least(TOPIC, f"{name}: order of the fold's f in the mesh width", "2", math.log2(abs(ratio)), 1.5),
            at_most(
                TOPIC, f"{name}: relative distance of the fold's f from {known}", "0", abs(limit / known - 1.0), 0.1
            ),
        ]
    claims.append(at_least(TOPIC, "Delta = 2: largest density at the fold", "> 0.99", found[2][2], 0.99))
    return Findings(tuple(claims), (Table("Folds.", ("box", "cells in x", "f", "largest n(0,y)"), rows),))


def family_of(aspect_ratio: float, cells: int, parameter: str = "f", stretch: float = 1.0) -> Family:
    """Half-wave states in one parameter."""
    mesh = Mesh.rectangle((cells, cells), aspect_ratio, stretch)
    return Family(Balance.of(GAS, VIBRATING, mesh, F), parameter)


def leading_rate(family: Family, point: Point) -> float:
    """The leading growth rate at a point of a branch."""
    return leading_mode(family, point).growth_rate.real


def leading_mode(family: Family, point: Point) -> Mode:
    """The leading mode at a point of a branch."""
    balance = family.at(point.vector[-1])
    state = balance.state(point.vector[:-1])
    return Linearization(state, VIBRATING, TAU, even(state.mesh)).leading()[0]


def bifurcation_kinds(case: BranchCase, cells: int) -> list[tuple[float, str]]:
    """(parameter, kind) of every bifurcation in the range."""
    family = family_of(case.aspect_ratio, cells, case.parameter)
    found = []
    for start in ExtendedBranch(family).bifurcations(np.geomspace(*case.limits, 13)):
        first = next(follow(family, start, case.limits, 0.2))
        found.append((start.value, "supercritical" if leading_rate(family, first) < 0.0 else "subcritical"))
    return found


def fold_of(aspect_ratio: float, limits: tuple[float, float], stretch: float, cells: int) -> tuple[float, float, float]:
    """(f, leading growth rate, largest wall density) at the fold of the branch from the right bifurcation."""
    family = family_of(aspect_ratio, cells, stretch=stretch)
    start = ExtendedBranch(family).bifurcations(np.geomspace(*limits, 13))[-1]
    for before, after in itertools.pairwise(follow(family, start, limits, 0.25)):
        fold = fold_between(family, before, after)
        if fold is not None:
            state = family.at(fold.vector[-1]).state(fold.vector[:-1])
            return fold.value, leading_rate(family, fold), wall_extremes(state.density, state.mesh)[1]
    raise AssertionError("the branch has no fold in its range")
