"""The extended state, computed by quadratures, against shooting on the paper's functions.

With w = log(z-1), and F and Q of the paper freed of their factors (z-1)^(-+1/2), the equation (F Z')' = L Q is the
initial value problem w' = g/F, g' = Q - g^2/(2F) in xi = x L^(1/2) with g = 0 at the elastic wall. In these unknowns
shooting is well-conditioned. It is done by an eighth-order Runge-Kutta method to a relative tolerance of 1e-12, with a
root search of its own for w(0); it shares nothing with the quadratures of `hydro.steady`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root

from hydro.errors import RunFailed
from hydro.gas import Grossman
from hydro.steady.extended import ExtendedState, Search, extended_state
from hydro.steady.grossman_limits import (
    dense_log_void,
    dense_rate,
    dense_start,
    dilute_profile,
    dilute_start,
    grain_diameter,
    knudsen_factor,
)  # fmt: skip
from hydro.steady.uniform_pressure import UniformPressure
from hydro.studies.orders import fitted_order
from hydro.verification.claims import Claim, Findings, Table, at_least, at_most, measurement
from hydro.walls import ThermalWall, VibratingWall

TOPIC = "Extended state"
ALPHA, A, C = 1.15, 1.0 - math.sqrt(3.0 / 8.0), math.sqrt(3.0 / 32.0)
GAMMA = 2.26
K, W, HOT = 2e-3, 114.0, 1.7  # conduction, and the strengths of the two walls
ERROR = 1e-8  # what p, n and log(z-1) may be off by
LOSSES = (1e2, 5e4, 1e8)
FRACTIONS = (1e-5, 0.0235, 0.9)
MORE_LOSSES = (1e2, 1e3, 1e4, 5e4, 1e6, 1e8)
MORE_FRACTIONS = (1e-5, 1e-3, 0.0235, 0.1, 0.5, 0.9)


def paper_f(w):
    """F of Eq. (F), times (z-1)^(1/2)."""
    e = np.exp(w)
    z = 1.0 + e
    inner = ALPHA * z * e + math.sqrt(32.0 / 3.0) * (z - A)
    return (z**2 + 2.0 * z - 1.0) * inner**2 / ((z - A) * z**1.5 * (z + 1.0) ** 2.5)


def paper_q(w):
    """Q of Eq. (Q), over (z-1)^(1/2)."""
    z = 1.0 + np.exp(w)
    return (z - A) / ((z + 1.0) ** 1.5 * z**0.5)


def paper_h(w):
    """H = F/G, over (z-1)^(1/2)."""
    z = 1.0 + np.exp(w)
    return (z * (z + 1.0)) ** -0.5


class Shot(NamedTuple):
    """A state found by shooting: w at x=0; w and g = F w' at x=1."""

    start: float
    end: float
    flux: float

    def wall_densities(self) -> tuple[float, float]:
        """n at the elastic and at the driving wall."""
        return 1.0 / (1.0 + math.exp(self.start)), 1.0 / (1.0 + math.exp(self.end))

    def pressures(self, L: float) -> tuple[float, float]:
        """p before the vibrating and before the thermal wall, from Eq. (wall1) and Eq. (state)."""
        z = 1.0 + math.exp(self.end)
        vibrating = W * float(paper_h(self.end)) / (C * self.flux * math.sqrt(L))
        return vibrating, HOT * (z + 1.0) / (z * math.exp(self.end))


def slopes(xi, y):
    """d/dxi of (w, g, mass)."""
    f = paper_f(y[0])
    return [y[1] / f, paper_q(y[0]) - y[1] ** 2 / (2.0 * f), 1.0 / (1.0 + np.exp(y[0]))]


def shoot(L: float, f: float) -> Shot:
    """The extended state of mean density f."""
    length = math.sqrt(L)

    def end(start: float) -> np.ndarray:
        return solve_ivp(slopes, (0.0, length), (start, 0.0, 0.0), method="DOP853", rtol=1e-12, atol=1e-15).y[:, -1]

    def excess(start: float) -> float:
        return math.log(end(start)[2] / (f * length))

    high = math.log(1.0 / f - 1.0)
    step = 1e-6
    while excess(high - step) <= 0.0:
        step *= 4.0
    start = float(brentq(excess, high - step, high, xtol=1e-14, rtol=1e-15)) if excess(high) < 0.0 else high
    w, g, _ = end(start)
    return Shot(start, float(w), float(g))


def states(full: bool) -> list[tuple[float, float]]:
    """The (L, f) at which methods are compared."""
    losses, fractions = (MORE_LOSSES, MORE_FRACTIONS) if full else (LOSSES, FRACTIONS)
    return [(L, f) for L in losses for f in fractions]


@measurement(TOPIC, "Against shooting")
def second_method(full: bool) -> Findings:
    """Relative differences of w = log(z-1) at x=0, of n at both walls, and of the pressure before either wall."""
    names = ("log(z-1) at x=0", "n at x=0", "n at x=1", "p, vibrating wall", "p, thermal wall")
    worst, rows = np.zeros(5), []
    for L, f in states(full):
        state, shot = extended_state(Grossman(L, K), f), shoot(L, f)
        ours = [state.w0, *state.wall_density, state.pressure(VibratingWall(K * W)), state.pressure(ThermalWall(HOT))]
        theirs = [shot.start, *shot.wall_densities(), *shot.pressures(L)]
        off = np.abs(np.array(ours) / np.array(theirs) - 1.0)
        worst = np.maximum(worst, off)
        rows.append((L, f, f"{state.w0:.9g}", f"{state.wall_density[1]:.9g}", f"{ours[3]:.9g}", float(off.max())))
    claims = tuple(at_most(TOPIC, name, "the same", float(off), ERROR) for name, off in zip(names, worst, strict=True))
    header = ("L", "f", "log(z-1) at x=0", "n at x=1", f"p, vibrating wall, W={W:g}", "largest difference")
    return Findings(claims, (Table("Extended states, and how far shooting is from them.", header, rows),))


@measurement(TOPIC, "The whole range")
def whole_range(full: bool) -> Findings:
    """States for L from 1e2 to 1e8 and f from 1e-5 to 0.9: how many searches fail, and how far states on elements of
    degree 14 and 20 differ, at the driving wall and anywhere between the nodes (relative to w where |w| > 1). The
    search relies on a mass that falls as w(0) rises: it is looked at on 400 values of w(0) for each L."""
    count = 25 if full else 9
    failures, closure, between, least = 0, 0.0, 0.0, 0.0
    for L in np.geomspace(1e2, 1e8, count):
        for f in [*np.geomspace(1e-5, 0.5, count), 0.7, 0.9]:
            gas = Grossman(float(L), K)
            try:
                state = extended_state(gas, float(f))
                fine = extended_state(gas, float(f), 20, near=state)
            except RunFailed:
                failures += 1
                continue
            closure = max(closure, abs(state.wall_density[1] / fine.wall_density[1] - 1.0))
            x = np.linspace(0.0, 1.0, 201)
            off = np.abs(state.log_void_at(x) - fine.log_void_at(x)) / np.maximum(1.0, np.abs(fine.log_void_at(x)))
            between, least = max(between, float(off.max())), min(least, state.w0)
    return Findings(
        (
            at_most(TOPIC, "searches that fail", "none", failures, 0),
            at_most(TOPIC, "steps of w(0) over which the mass does not fall", "none", sum(map(rises, LOSSES)), 0),
            at_most(TOPIC, "n at x=1 by elements of degree 14 and 20", "the same", closure, ERROR),
            at_most(TOPIC, "w between nodes by elements of degree 14 and 20", "the same", between, 1e-10),
            at_most(TOPIC, "log10(1-n) at x=0 of the densest state", "-38 and below", least / math.log(10.0), -38.0),
        )
    )


def rises(L: float) -> int:
    """How often the mass fails to fall as w(0) rises, from boxes of f = 0.95 to those of f = 1e-5."""
    search = Search(UniformPressure.of(Grossman(L, K)), 0.5, 14)
    low = extended_state(Grossman(L, K), 0.95).w0
    masses = [search.excess(w) for w in np.linspace(low, math.log(1e5), 400).tolist()]
    return int(np.sum(np.diff(masses) >= 0.0))


@measurement(TOPIC, "The two driving walls")
def two_walls(full: bool) -> Findings:
    """The steady equations in T and heat flux, with an unknown pressure, solved by shooting before either wall with
    the closure's p, kappa and I: L = 5e4, f = 0.0235. Then the heat that the wall gives against the heat that
    collisions take, int I dx by Gauss's rule."""
    gas, f = Grossman(5e4, K), 0.0235
    state = extended_state(gas, f)
    x = np.linspace(0.0, 1.0, 21)
    densities, budgets = [], []
    for wall in (VibratingWall(K * W), ThermalWall(HOT)):
        densities.append(by_temperature(gas, f, wall, state, x))
        budgets.append(budget(gas, wall, state))
    names = ("vibrating", "thermal")
    claims = [
        at_most(TOPIC, f"n(x) before the {name} wall, from T and heat flux", "the same", float(off), ERROR)
        for name, off in zip(names, (np.max(np.abs(n / state.density_at(x) - 1.0)) for n in densities), strict=True)
    ]
    coincide = float(np.max(np.abs(densities[0] / densities[1] - 1.0)))
    claims.append(at_most(TOPIC, "n(x) before the two walls", "the same", coincide, ERROR))
    claims += [
        at_most(TOPIC, f"heat of the {name} wall against collisions", "balance", off, ERROR)
        for name, off in zip(names, budgets, strict=True)
    ]
    return Findings(tuple(claims))


def by_temperature(gas: Grossman, f: float, wall, like: ExtendedState, x: np.ndarray) -> np.ndarray:
    """n(x) of the steady state, from dT/dx = q/kappa, dq/dx = I with q(0) = 0; unknown are T(0) and p."""

    def march(unknowns, points):
        T0, p = np.exp(unknowns)

        def slope(_, y):
            n = gas.density(p, y[0])
            return [y[1] / gas.conductivity(n, y[0]), gas.cooling(n, y[0]), n]

        run = solve_ivp(slope, (0.0, 1.0), (T0, 0.0, 0.0), method="DOP853", rtol=1e-12, atol=1e-18, t_eval=points)
        return gas.density(p, run.y[0]), run.y[:, -1]

    def off(unknowns):
        n, (T, q, mass) = march(unknowns, [1.0])
        if isinstance(wall, ThermalWall):
            return [math.log(mass / f), math.log(T / wall.temperature)]
        return [math.log(mass / f), math.log(q / (wall.strength * n[-1] * math.sqrt(T)))]

    p = like.pressure(wall)
    start = np.log([float(like.temperature_at(0.0, wall)), p]) + np.array([0.02, -0.02])  # not right at the answer
    return march(root(off, start, tol=1e-13).x, x)[0]


def budget(gas: Grossman, wall, state: ExtendedState) -> float:
    """Relative difference of the heat through x=1 and int I dx."""
    nodes, weights = np.polynomial.legendre.leggauss(400)
    x = 0.5 * (1.0 + nodes)
    n, p = state.density_at(x), state.pressure(wall)
    lost = float(0.5 * weights @ gas.cooling(n, gas.temperature(n, p)))
    h = 1e-4
    T = state.temperature_at(1.0 - h * np.arange(5.0), wall)
    slope = float(np.array([25.0, -48.0, 36.0, -16.0, 3.0]) @ T) / (12.0 * h)
    given = float(gas.conductivity(state.density_at(1.0), T[0]) * slope)
    if isinstance(wall, VibratingWall):
        given = wall.strength * float(state.density_at(1.0)) * math.sqrt(T[0])
    return abs(given / lost - 1.0)


@measurement(TOPIC, "Analytic limits")
def limits(full: bool) -> Findings:
    """Dense: u = (z-1)^(1/2) = u(0) cosh(kx) from the computed u(0), its deviation where z-1 is 1e-4 to 1e-2, and the
    formula for u(0) of boxes with 1 - f from 1e-3 to 1e-5. Dilute: n at both walls for L f^2 = 1 and small f. Each
    formula leaves out terms of relative order z-1 or 1/z: its error has to fall as their first power."""
    gas = Grossman(1e6, K)
    state = extended_state(gas, 0.3)
    w = np.log([1e-4, 1e-3, 1e-2])
    x = np.interp(w, state.w, state.x)
    inside = np.abs(state.log_void_at(x) - dense_log_void(gas, state.w0, x))
    inside_orders = fitted_order(list(np.exp(state.log_void_at(x))), list(inside))
    voids, boxes = (1e-3, 1e-4, 1e-5), []
    for void in voids:
        box = Grossman(1e2, K)
        boxes.append(abs(extended_state(box, 1.0 - void).w0 - dense_start(box, 1.0 - void)))
    fractions, starts, ends = (1e-3, 1e-4, 1e-5), [], []
    for f in fractions:
        dilute = Grossman(1.0 / f**2, K)
        n = extended_state(dilute, f).wall_density
        starts.append(abs(math.exp(-dilute_start(dilute, f)) / n[0] - 1.0))
        ends.append(abs(dilute_profile(dilute, f)[1][-1] / n[1] - 1.0))
    rows = [
        *(("dense, 1-f", void, off) for void, off in zip(voids, boxes, strict=True)),
        *(("dilute, f", f, max(pair)) for f, *pair in zip(fractions, starts, ends, strict=True)),
    ]
    claims = (
        at_most(TOPIC, "k L^(-1/2) less 0.2165", "the paper's number", abs(dense_rate(gas) / 1e3 - 0.2165), 5e-5),
        _first_order("u = u(0) cosh(kx) inside a cluster, in z-1", inside_orders),
        _first_order("u(0) of a dense box, in 1-f", fitted_order(voids, boxes)),
        _first_order("n(0) of a dilute box, in f", fitted_order(fractions, starts)),
        _first_order("n(1) of a dilute box, in f", fitted_order(fractions, ends)),
    )
    return Findings(claims, (Table("Errors of the limits, relative.", ("limit", "at", "error"), rows),))


def _first_order(statement: str, order: float) -> Claim:
    return at_least(TOPIC, f"order of the error of {statement}", "1", order, 0.95)


@measurement(TOPIC, "Knudsen number")
def knudsen(full: bool) -> Findings:
    """Largest mean free path over the length on which T changes, over (1-r^2)^(1/2), with the diameter that L and
    1-r^2 fix: over all of L from 1e2 to 1e8 and f from 1e-5 to 0.9. Were it not of order one, 1-r^2 << 1 would not be
    the criterion of validity that the paper reads off the limits."""
    count = 21 if full else 7
    largest, rows = 0.0, []
    for L in np.geomspace(1e2, 1e8, count):
        here = []
        for f in np.geomspace(1e-5, 0.9, 2 * count):
            gas = Grossman(float(L), K)
            here.append(extended_state(gas, float(f)).knudsen(grain_diameter(gas, 1.0, GAMMA)))
        rows.append((float(L), max(here)))
        largest = max(largest, *here)
    gas = Grossman(1e8, K)
    limit = knudsen_factor(gas, GAMMA)
    far = extended_state(gas, 0.01).knudsen_at(np.array([0.999]), grain_diameter(gas, 1.0, GAMMA))[0]
    return Findings(
        (
            at_most(TOPIC, "largest Knudsen number over (1-r^2)^(1/2)", "of order one", largest, 1.0),
            at_most(
                TOPIC, "its value in the gas at L=1e8, against the limit", f"{limit:.4f}", abs(far / limit - 1), 0.01
            ),
        ),
        (Table("Largest Knudsen number over (1-r^2)^(1/2), any f.", ("L", "Kn/(1-r^2)^(1/2)"), rows),),
    )
