"""Marginal stability of the extended state, and what the paper says about its curves.

The second method is a shooting method: eta = phi'/phi obeys eta' = V + kappa^2 - eta^2; its angle, tan(theta) = eta,
stays finite where phi vanishes. The state is integrated beside it with the paper's F, Q and H, whose derivatives are
taken by complex steps, and kappa^2 is found by a root search: nothing is shared with the eigenvalue problem.
"""

from __future__ import annotations

import math
import time
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from hydro.gas import Grossman
from hydro.steady.extended import extended_state, integrate
from hydro.steady.grossman_limits import dilute_aspect_ratio, dilute_end, growth_of_least_fraction
from hydro.steady.marginal import (
    Tongue,
    critical_aspect_ratio,
    principal_mode,
    tongue,
    vanishing_tongue,
)
from hydro.steady.uniform_pressure import UniformPressure
from hydro.studies.orders import fitted_order
from hydro.verification.claims import Claim, Findings, Table, at_least, at_most, measurement
from hydro.verification.extended import paper_f, paper_h, paper_q, shoot

TOPIC = "Marginal stability"
WALLS = ("vibrating", "thermal")
STEP = 1e-30  # of complex-step derivatives, which lose no digits
ERROR = 1e-7  # what critical aspect ratios may be off by, relatively
PLACES = ((1e3, 0.05), (5e4, 1e-3), (5e4, 0.0235), (5e4, 0.03), (1e6, 0.006))
MORE_PLACES = ((300.0, 0.05), (5e3, 0.05), (5e4, 3e-4), (5e4, 0.012), (1e6, 1e-4), (1e6, 0.003), (1e7, 0.0022))
LOSSES = (1e3, 1e4, 5e4, 1e6)
MORE_LOSSES = (3e2, 5e2, 1e3, 3e3, 1e4, 5e4, 1e5, 1e6, 1e7, 1e8)
VANISHING = {"vibrating": (1e2, 1e3), "thermal": (1e3, 1e4)}  # between which the tongues vanish
LARGE = (1e6, 1e7, 1e8, 1e9)
SECONDS = 5.0  # for 100 area fractions before both walls


def gas(L: float) -> Grossman:
    """The paper's gas; K makes no difference."""
    return Grossman(L, 1.0)


def log_slope(function: Any, w: float) -> float:
    """d log function/dw."""
    return float(np.log(function(w + 1j * STEP)).imag / STEP)


def shot_eigenvalue(L: float, f: float, wall: str, near: float) -> float:
    """kappa^2 L_x^2/L by shooting, within 1% of `near`."""
    start = shoot(L, f).start

    def slopes(xi: float, y: np.ndarray, eigenvalue: float) -> list[float]:
        w, g, angle = y
        conductance, cooling = paper_f(w), paper_q(w)
        growth = cooling * (log_slope(paper_q, w) + 0.5) / conductance + eigenvalue
        cosine, sine = math.cos(angle), math.sin(angle)
        return [g / conductance, cooling - g * g / (2.0 * conductance), growth * cosine**2 - sine**2]

    def miss(eigenvalue: float) -> float:
        run = solve_ivp(
            slopes, (0.0, math.sqrt(L)), (start, 0.0, 0.0), args=(eigenvalue,), method="DOP853", rtol=1e-12, atol=1e-15
        )
        w, g, angle = run.y[:, -1]
        wanted = -0.5 * math.pi if wall == "thermal" else math.atan(g / paper_f(w) * (0.5 + log_slope(paper_h, w)))
        return float(angle - wanted)

    return float(brentq(miss, 0.99 * near, 1.01 * near, xtol=1e-14 * near, rtol=1e-14))


@measurement(TOPIC, "Against shooting")
def second_method(full: bool) -> Findings:
    """Relative difference of Delta_1, with the estimate of its error that every result carries: the distance to the
    same calculation on elements of lower degree."""
    rows, worst, estimate = [], 0.0, 0.0
    for L, f in PLACES + (MORE_PLACES if full else ()):
        state = extended_state(gas(L), f)
        for wall in WALLS:
            found = critical_aspect_ratio(state, wall)
            if found.aspect_ratio is None or found.error is None:
                continue
            near = principal_mode(state, wall).eigenvalue
            other = math.pi / math.sqrt(shot_eigenvalue(L, f, wall, near) * L)
            off, error = abs(found.aspect_ratio / other - 1.0), found.error / found.aspect_ratio
            worst, estimate = max(worst, off), max(estimate, error)
            rows.append((L, f, wall, f"{found.aspect_ratio:.10g}", error, off))
    header = ("L", "f", "wall", "Delta_1", "estimated error", "difference from shooting")
    return Findings(
        (
            at_most(TOPIC, "Delta_1 against shooting", "the same", worst, ERROR),
            at_most(TOPIC, "largest estimated error of Delta_1", "small", estimate, ERROR),
        ),
        (Table("Critical aspect ratios; errors are relative.", header, rows),),
    )


@measurement(TOPIC, "Time for a curve")
def speed(full: bool) -> Findings:
    """Processor seconds for 100 area fractions at L = 5e4, both walls, with error estimates."""
    extended_state(gas(5e4), 0.02)
    started = time.process_time()
    for f in np.linspace(1e-3, 0.036, 100):
        state = extended_state(gas(5e4), float(f))
        for wall in WALLS:
            critical_aspect_ratio(state, wall)
    seconds = time.process_time() - started
    return Findings((at_most(TOPIC, "seconds for 100 area fractions, both walls", "quick", seconds, SECONDS),))


@measurement(TOPIC, "Tongues")
def tongues(full: bool) -> Findings:
    """The interval f1 < f < f2 of the area fraction in which some aspect ratio is unstable, the least Delta_1 and its
    place, before both walls. f1 before the vibrating wall against 3 alpha^2 (1+a)/L, which leaves out terms of
    relative order 1/L. The paper: Delta_min L^(1/2) about 140; f2-f1 shrinks as L grows; the thermal tongue is
    narrower."""
    found = {(L, wall): tongue(gas(L), wall) for L in (MORE_LOSSES if full else LOSSES) for wall in WALLS}
    losses = sorted({L for L, _ in found})
    driven = {L: found[L, "vibrating"] for L in losses}
    large = [L for L in losses if L >= 1e4]
    starts = [abs((driven[L].f1 or math.nan) / dilute_end(gas(L)) - 1.0) for L in large]
    widths = [width(driven[L]) for L in losses if L >= 1e3]
    narrower = [width(found[L, "thermal"]) / width(driven[L]) for L in losses if found[L, "thermal"].f1]
    least = (driven[5e4].aspect_ratio_min or math.nan) * math.sqrt(5e4)
    claims = (
        at_most(TOPIC, "Delta_min L^(1/2) at L=5e4, from 144.8", "the known value", abs(least - 144.8), 0.05),
        at_least(TOPIC, "order of f1 - 3 alpha^2 (1+a)/L in 1/L, relative", "1", -fitted_order(large, starts), 0.95),
        at_most(TOPIC, "largest ratio of neighbouring f2-f1, L >= 1e3", "below 1", largest_ratio(widths), 1.0),
        at_most(TOPIC, "largest width of a thermal over a vibrating tongue", "below 1", max(narrower), 1.0),
    )
    header = ("L", "wall", "f1", "f1 L/(3 alpha^2 (1+a))", "f2", "f_min", "Delta_min", "Delta_min L^(1/2)")
    rows = [tongue_row(L, wall, entry) for (L, wall), entry in found.items()]
    return Findings(claims, (Table("Tongues m = 1.", header, rows),))


def width(entry: Tongue) -> float:
    """f2 - f1, zero for none."""
    return (entry.f2 or 0.0) - (entry.f1 or 0.0)


def largest_ratio(values: list[float]) -> float:
    """Of a value to the one before it."""
    return max(after / before for before, after in pairwise(values))


def tongue_row(L: float, wall: str, entry: Tongue) -> tuple[float | str, ...]:
    """A row of the table of tongues."""
    if entry.f1 is None or entry.aspect_ratio_min is None:
        return (L, wall, *6 * ["none"])
    scaled = entry.aspect_ratio_min * math.sqrt(L)
    numbers = (entry.f1, entry.f1 / dilute_end(gas(L)), entry.f2, entry.f_min, entry.aspect_ratio_min, scaled)
    return (L, wall, *(f"{value:.7g}" for value in numbers))


@measurement(TOPIC, "Where tongues vanish")
def vanishing(full: bool) -> Findings:
    """The L below which the extended state is stable for every aspect ratio, and the area fraction to which the
    tongue shrinks there; a ten-thousandth above and below it, what a search for the tongue gives."""
    claims, rows = [], []
    for wall, bounds in VANISHING.items():
        L, f = vanishing_tongue(gas(1.0), "L", wall, *bounds)
        above, below = tongue(gas(1.0001 * L), wall), tongue(gas(0.9999 * L), wall)
        rows.append((wall, f"{L:.6g}", f"{f:.5g}", width(above), width(below)))
        claims.append(at_least(TOPIC, f"{wall} wall: f2-f1 just above", "there", width(above), 1e-4))
        claims.append(at_most(TOPIC, f"{wall} wall: f2-f1 just below", "none", width(below), 0.0))
    header = ("wall", "L", "f", "f2-f1 at 1.0001 L", "f2-f1 at 0.9999 L")
    return Findings(tuple(claims), (Table("Where tongues vanish.", header, rows),))


@measurement(TOPIC, "Large L")
def large_losses(full: bool) -> Findings:
    """In xi = x L^(1/2) the cluster and the mode do not know the far wall: Delta_min L^(1/2) converges, exponentially
    in L^(1/2), to the same number before both walls. The gas before the cluster, n = alpha/(2^(1/2) xi), adds to the
    mass: f_min L^(1/2) = (alpha/8^(1/2)) log L + constant. A fit, with terms in L^(-1/2) and L^(-1/2) log L, measures
    slope and constant; the mass of the same cluster in an endless box gives the constant directly."""
    found = {(L, wall): tongue(gas(L), wall) for L in LARGE for wall in WALLS}
    scaled = [(found[L, wall].aspect_ratio_min or math.nan) * math.sqrt(L) for L in LARGE for wall in WALLS]
    masses = [(found[L, "vibrating"].f_min or math.nan) * math.sqrt(L) for L in LARGE]
    slope, constant = logarithm(LARGE, masses)
    wanted, endless = growth_of_least_fraction(gas(1.0)), endless_constant(LARGE[-1], masses[-1])
    rows: list[tuple[float | str, ...]] = [
        (
            L,
            f"{masses[k]:.9g}",
            f"{masses[k] - wanted * math.log(L):.7g}",
            f"{scaled[2 * k]:.10g}",
            f"{scaled[2 * k + 1]:.10g}",
        )
        for k, L in enumerate(LARGE)
    ]
    rows.append(("fit", f"{slope:.5g} log L + {constant:.5g}", f"{constant:.5g}", "", ""))
    rows.append(("endless box", f"{wanted:.7g} log L + {endless:.7g}", f"{endless:.7g}", "", ""))
    header = ("L", "f_min L^(1/2)", "less (alpha/8^(1/2)) log L", "Delta_min L^(1/2), vibrating", "thermal")
    spread = max(scaled) / min(scaled) - 1.0
    return Findings(
        (
            at_most(TOPIC, "Delta_min L^(1/2), L from 1e6 to 1e9, both walls: spread", "six digits", spread, 5e-7),
            at_most(TOPIC, "slope of f_min L^(1/2) in log L", f"{wanted:.4f}", abs(slope / wanted - 1.0), 1e-3),
            at_most(TOPIC, "its constant, from the endless box", "the same", abs(constant / endless - 1.0), 1e-2),
        ),
        (Table("Large L.", header, rows),),
    )


def logarithm(losses: tuple[float, ...], masses: list[float]) -> tuple[float, float]:
    """(slope, constant) of mass = slope log L + constant, with terms in L^(-1/2) and L^(-1/2) log L."""
    L = np.array(losses)
    terms = np.stack([np.log(L), np.ones_like(L), L**-0.5, L**-0.5 * np.log(L)], axis=1)
    slope, constant, *_ = np.linalg.lstsq(terms, np.array(masses), rcond=None)[0]
    return float(slope), float(constant)


def endless_constant(L: float, mass: float) -> float:
    """The constant from the state that the minimum tends to, continued to where the gas is very dilute, w = 28."""
    start = extended_state(gas(L), mass / math.sqrt(L)).w0
    profile = integrate(UniformPressure.of(gas(1.0)), start, np.array([0.0, 0.25, *range(1, 27)]), 14)
    return float(profile.mass[-1, -1] - 2.0 * growth_of_least_fraction(gas(1.0)) * math.log(profile.xi[-1, -1]))


@measurement(TOPIC, "Vibrating and thermal wall")
def two_walls(full: bool) -> Findings:
    """Where the curves of the two walls coincide, the mode sits at the elastic wall: half of int phi^2 dx lies within
    x_half of it, and phi at the vibrating wall is small. As f goes to zero before the thermal wall, kappa^2 tends to
    that of cos(pi x/2), -pi^2/4: no aspect ratio is critical. Before the vibrating wall it is, down to f1."""
    rows, claims = [], []
    for L in (5e4, 1e6) if full else (5e4,):
        place = tongue(gas(L), "vibrating").f_min or math.nan
        for f in place * np.array([0.3, 0.5, 0.75, 1.0, 1.25]):
            rows.append((L, float(f), *coincidence(L, float(f))))
    place = tongue(gas(1e6), "vibrating").f_min or math.nan
    apart, half, edge = coincidence(1e6, place)
    claims.append(at_most(TOPIC, "Delta_1 before the two walls at L=1e6, f=f_min", "the same", number(apart), 1e-6))
    claims.append(at_most(TOPIC, "x_half of its mode", "localized", half, 0.1))
    claims.append(at_most(TOPIC, "phi at the vibrating wall over its peak", "small", edge, 1e-4))
    dilute = [extended_state(gas(L), f) for L in (1e3, 5e4, 1e6) for f in (1e-6, 1e-5, 1e-4) if f < 1e-2 / math.sqrt(L)]
    off = [
        abs(principal_mode(state, "thermal").eigenvalue * state.gas.L / (-0.25 * math.pi**2) - 1.0) for state in dilute
    ]
    claims.append(at_most(TOPIC, "kappa^2 before the thermal wall, dilute, from -pi^2/4", "the same", max(off), 0.01))
    header = ("L", "f", "Delta thermal/vibrating - 1", "x_half", "phi(1)/peak")
    return Findings(
        tuple(claims), (Table("How far the two walls' Delta_1 differ, and where the mode is.", header, rows),)
    )


def coincidence(L: float, f: float) -> tuple[float | str, float, float]:
    """(thermal over vibrating Delta_1 less 1, x_half and phi(1) of the vibrating wall's mode)."""
    state = extended_state(gas(L), f)
    driven, held = (critical_aspect_ratio(state, wall).aspect_ratio for wall in WALLS)
    mode = principal_mode(state, "vibrating")
    apart = held / driven - 1.0 if held and driven else "no thermal one"
    return apart, mode.inner_half, float(mode.phi[-1])


def number(value: float | str) -> float:
    """The value, NaN for words."""
    return math.nan if isinstance(value, str) else abs(value)


@measurement(TOPIC, "The dilute formula")
def dilute(full: bool) -> Findings:
    """Eq. (asymp) against Delta_1 before the vibrating wall, at ten times f_1, where L f^2 falls like 1/L: its
    relative error has to fall like that too, or faster."""
    losses, errors = (1e4, 1e5, 1e6, 1e7), []
    for L in losses:
        f = 10.0 * dilute_end(gas(L))
        exact, formula = critical_aspect_ratio(extended_state(gas(L), f), "vibrating"), dilute_aspect_ratio(gas(L), f)
        errors.append(abs((formula or math.nan) / (exact.aspect_ratio or math.nan) - 1.0))
    rows = [(L, 10.0 * dilute_end(gas(L)), error) for L, error in zip(losses, errors, strict=True)]
    claims: tuple[Claim, ...] = (
        at_least(TOPIC, "order of the error of Eq. (asymp) in 1/L", "1", -fitted_order(losses, errors), 0.95),
        at_most(TOPIC, "its error at L = 1e7", "small", errors[-1], 1e-3),
    )
    return Findings(claims, (Table("Relative error of Eq. (asymp).", ("L", "f", "error"), rows),))
