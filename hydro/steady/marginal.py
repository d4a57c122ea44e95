"""Marginal stability of the extended state: the aspect ratio at which it gives way to a state that depends on y.

A small change of the extended state, psi(x) cos(pi m y/Delta), is marginal when phi = F psi obeys Eq. (phi),

    d^2 phi/dx^2 = (V + kappa^2) phi,    kappa = pi m/Delta,    dphi/dx = 0 at x = 0,

and at x=1 either d phi/dx = b phi with b = d log(eps^(1/2) H)/dx at the vibrating wall, Eq. (bound2), or phi = 0 at
the thermal one. So kappa^2 is the largest eigenvalue of d^2/dx^2 - V, and there is a critical aspect ratio where it
is positive. It is found on the elements of the extended state, in their unit of length.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import LinAlgError, cho_solve_banded, cholesky_banded
from scipy.optimize import brentq, minimize_scalar

from hydro.choices import WALL_CONDITIONS
from hydro.errors import RunFailed
from hydro.gas.closure import described
from hydro.steady.elements import ReferenceElement, reference_element
from hydro.steady.extended import DENSE, ExtendedState, extended_state, joined
from hydro.steady.uniform_pressure import UniformPressure

COARSE = 12  # degree of the second calculation, whose distance from the first estimates the error
ITERATIONS = 80
RESIDUAL = 1e-13  # of the eigenvalue problem, relative to its largest entry
NOISE = 1e-8  # of the eigenfunction, relative to its peak: below it a sign means nothing
LEAST_F, MOST_F = 1e-3, 0.98  # tongues are looked for from area fractions LEAST_F/loss to MOST_F of packing
SCAN = 56  # how many area fractions that look takes
NEAR = 0.02  # half-width in log f of the polynomial that places a minimum, its number of points
POINTS = 9


def vibrating(state: ExtendedState) -> float | None:
    """b = dw/dxi d log(eps^(1/2) H)/dw at the wall, Eq. (bound2)."""
    disks, w = UniformPressure.of(state.gas), state.profile.w[-1, -1]
    return float(state.profile.flux[-1, -1] / disks.conductance(w) * disks.wall_supply_slope(w))


def thermal(state: ExtendedState) -> float | None:
    """The temperature of the wall is fixed, and with it the density there."""
    return None


@dataclass(frozen=True)
class Mode:
    """The principal eigenfunction phi at the nodes x, its peak 1, and kappa^2 in the unit of length of the elements."""

    eigenvalue: float
    x: np.ndarray
    phi: np.ndarray

    @property
    def inner_half(self) -> float:
        """The x within which half of int phi^2 dx lies: small when the mode sits at the elastic wall."""
        share = np.concatenate([[0.0], np.cumsum(np.diff(self.x) * 0.5 * (self.phi[1:] ** 2 + self.phi[:-1] ** 2))])
        return float(np.interp(0.5 * share[-1], share, self.x))


@dataclass(frozen=True)
class Critical:
    """A critical aspect ratio Delta_m with an estimate of its error; None where no aspect ratio is critical."""

    aspect_ratio: float | None
    error: float | None

    def times(self, m: int) -> Critical:
        """Delta_m = m Delta_1 of this Delta_1."""
        if self.aspect_ratio is None or self.error is None:
            return self
        return Critical(m * self.aspect_ratio, m * self.error)


@dataclass(frozen=True)
class Tongue:
    """The interval f1 < f < f2 in which Delta_1 exists, and the least Delta_1 and its place; None when it is empty."""

    f1: float | None = None
    f2: float | None = None
    f_min: float | None = None
    aspect_ratio_min: float | None = None


def critical_aspect_ratio(state: ExtendedState, wall: str, wave: int = 1) -> Critical:
    """Delta_m of the extended state before the wall of the given kind, m = `wave`.

    The error is estimated by all of it, extended state and eigenvalue, on elements of lower degree.
    """
    fine = aspect_ratio_of(principal_mode(state, wall).eigenvalue, state.length)
    if fine is None:
        return Critical(None, None)
    rough_state = extended_state(state.gas, state.f, COARSE, near=state)
    rough = aspect_ratio_of(principal_mode(rough_state, wall).eigenvalue, state.length)
    return Critical(fine, math.inf if rough is None else abs(fine - rough)).times(wave)


def tongue(gas: Any, wall: str, scan: int = SCAN) -> Tongue:
    """The tongue m=1 of a gas before the wall of the given kind.

    The reduced eigenvalue is looked at on `scan` area fractions: it has one peak in f, and no tongue means that the
    peak is not positive.
    """
    place = Eigenvalues(gas, wall)
    grid = np.linspace(math.log(min(LEAST_F / place.loss, 1e-5)), math.log(MOST_F * densest(gas)), scan)
    heights = np.array([place.reduced(u) for u in grid])
    k = int(np.argmax(heights))
    inside, height = float(grid[k]), heights[k]
    if height <= 0.0:
        inside, height = place.peak(float(grid[max(k - 1, 0)]), float(grid[min(k + 1, scan - 1)]))
    if height <= 0.0:
        return Tongue()
    ends = [*grid[(grid < inside) & (heights <= 0.0)][-1:], *grid[(grid > inside) & (heights <= 0.0)][:1]]
    if len(ends) < 2:
        raise RunFailed(
            f"the tongue at {described(gas)} before the {wall} wall reaches beyond "
            f"{math.exp(grid[0]):.3g} < f < {math.exp(grid[-1]):.3g}"
        )
    low, high = (brentq(place.reduced, min(u, inside), max(u, inside), xtol=1e-14) for u in ends)
    least, value = place.highest(low, high)
    return Tongue(math.exp(low), math.exp(high), math.exp(least), aspect_ratio_of(value, math.sqrt(place.loss)))


def densest(gas: Any) -> float:
    """Up to where tongues are looked for: the density of packing, or n_c if the closure never packs."""
    packed = gas.packing_density()
    return packed if packed < math.inf else 1.0


def vanishing_tongue(gas: Any, parameter: str, wall: str, low: float, high: float) -> tuple[float, float]:
    """(value, f) at which the tongue m=1 before the wall of the given kind vanishes, as a parameter of the gas grows.

    RunFailed if it does not do so for `low` < value < `high`.
    """
    around = np.log([1e-3 * densest(gas), 0.7 * densest(gas)])

    def height(u: float) -> float:
        return Eigenvalues(gas.with_parameter(parameter, math.exp(u)), wall).peak(*around)[1]

    bounds = math.log(low), math.log(high)
    below, above = height(bounds[0]), height(bounds[1])
    if not below < 0.0 < above:
        ends = f"{parameter} = {low:g} and {parameter} = {high:g}"
        raise RunFailed(f"the tongue before the {wall} wall does not vanish between {ends}")
    value = math.exp(brentq(height, *bounds, xtol=1e-10))
    return value, math.exp(Eigenvalues(gas.with_parameter(parameter, value), wall).peak(*around)[0])


class Eigenvalues:
    """The largest kappa^2 of a gas as a function of u = log f."""

    def __init__(self, gas: Any, wall: str):
        self.gas, self.wall, self.loss = gas, wall, UniformPressure.of(gas).loss

    def at(self, u: float) -> float:
        """kappa^2 in units of loss/L_x^2."""
        return principal_mode(extended_state(self.gas, math.exp(u)), self.wall).eigenvalue

    def reduced(self, u: float) -> float:
        """kappa^2 over f^3/(1 + loss^(3/2) f^3), which has one peak in f.

        Before the vibrating wall kappa^2 fades like -f^3 in the dilute limit, so that a tongue which does not rise
        above zero would be overlooked; before the thermal wall kappa^2/f^3 rises at the other end.
        """
        return self.at(u) * (math.exp(-3.0 * u) + self.loss**1.5)

    def peak(self, low: float, high: float) -> tuple[float, float]:
        """Place and height of the peak of the reduced kappa^2 between low and high."""
        return _peak(self.reduced, low, high)

    def highest(self, low: float, high: float) -> tuple[float, float]:
        """Place and height of the peak of kappa^2."""
        return _peak(self.at, low, high)


def _peak(function: Callable[[float], float], low: float, high: float) -> tuple[float, float]:
    """Place and height of the maximum of a smooth function with one peak.

    Searching alone would place it to half of the digits only; the derivative of a polynomial through points around it
    gives it to nearly all.
    """
    found = minimize_scalar(lambda u: -function(u), bounds=(low, high), method="bounded", options={"xatol": 1e-4}).x
    half = min(NEAR, 0.5 * (found - low), 0.5 * (high - found))
    near = np.polynomial.Chebyshev.interpolate(np.vectorize(function), POINTS - 1, domain=[found - half, found + half])
    places = near.deriv().roots()
    places = places[np.abs(places.imag) < 1e-12].real
    place = float(places[np.argmin(np.abs(places - found))]) if places.size else float(found)
    return place, float(near(place))


def aspect_ratio_of(eigenvalue: float, length: float) -> float | None:
    """Delta_1 = pi/kappa; None when kappa^2 is not positive."""
    return math.pi / (math.sqrt(eigenvalue) * length) if eigenvalue > 0.0 else None


def principal_mode(state: ExtendedState, wall: str) -> Mode:
    """The mode of largest kappa^2."""
    problem = Problem.of(state, WALL_CONDITIONS[wall](state))
    phi = problem.principal()
    phi /= phi[np.argmax(np.abs(phi))]
    if phi.min() < -NOISE:
        place = f"{described(state.gas)}, f = {state.f:g}"
        raise RunFailed(f"marginal stability at {place}: not the principal mode was found")
    return Mode(-problem.quotient(phi), problem.x, phi)


@dataclass(frozen=True)
class Problem:
    """int (phi'^2 + V phi^2) dxi - b phi(1)^2 on the elements, over int phi^2 dxi: kappa^2 is minus its minimum."""

    element: ReferenceElement
    stiffness: np.ndarray  # (elements, nodes): quadrature weights of (dphi/dr)^2
    mass: np.ndarray  # (elements, nodes): those of phi^2
    potential: np.ndarray  # (elements, nodes): V
    supply: float | None  # b
    x: np.ndarray  # nodes in one row

    @classmethod
    def of(cls, state: ExtendedState, supply: float | None) -> Problem:
        """The problem for an extended state; a mode vanishes deep inside a cluster, and that part is left out."""
        profile, element = state.profile, reference_element(state.degree)
        first = int(np.searchsorted(profile.w[:, 0], DENSE - 0.5)) if profile.w[-1, -1] > 0.5 * DENSE else 0
        part = slice(first, None)
        half = 0.5 * np.ptp(profile.s[part], axis=1)[:, None]
        slope = half * profile.xi_slope[part]
        w = profile.w[part]
        x = joined(profile.xi[part]) / profile.xi[-1, -1]
        potential = UniformPressure.of(state.gas).potential(w)
        return cls(element, element.weights / slope, element.weights * slope, potential, supply, x)

    def quotient(self, phi: np.ndarray) -> float:
        """The quotient, element by element: its terms cancel in dilute states, and no digit is lost before they do."""
        degree = self.element.degree
        inside = np.stack([phi[k : k + degree + 1] for k in range(0, len(phi) - 1, degree)])
        slope = (inside - inside[:, :1]) @ self.element.derivative.T
        form = np.sum(self.stiffness * slope**2 + self.mass * self.potential * inside**2)
        return float((form - (self.supply or 0.0) * phi[-1] ** 2) / np.sum(self.mass * inside**2))

    def principal(self) -> np.ndarray:
        """phi of the least quotient, at the nodes in one row.

        Inverse iteration with a shift that approaches the least eigenvalue from below: a Cholesky factor exists
        only below the whole spectrum, so no other eigenvalue can be taken for it.
        """
        band, root = self._matrix()
        low = shift = self._bound() - RESIDUAL * float(band[0].max())
        vector = root / np.linalg.norm(root)
        for _ in range(ITERATIONS):
            try:
                factor = cholesky_banded(_shifted(band, shift), lower=True, check_finite=False)
            except LinAlgError:
                shift = 0.5 * (low + shift)
                continue
            low = shift
            vector = cho_solve_banded((factor, True), vector, check_finite=False)
            vector /= np.linalg.norm(vector)
            image = _product(band, vector)
            value = float(vector @ image)
            residual = float(np.linalg.norm(image - value * vector))
            if residual <= RESIDUAL * float(band[0].max()):
                break
            shift = max(value - 2.0 * residual, 0.5 * (low + value))
        else:
            raise RunFailed(f"marginal stability: the eigenvalue {value:.3e} kept a residual of {residual:.1e}")
        phi = vector / root
        return phi if self.supply is not None else np.append(phi, 0.0)

    def _matrix(self) -> tuple[np.ndarray, np.ndarray]:
        """The problem as a symmetric matrix for phi times the root of its mass: its lower band, and that root."""
        degree, D = self.element.degree, self.element.derivative
        local = np.einsum("ki,eki,kj->eij", D, self.stiffness[:, :, None] * np.ones(degree + 1), D, optimize=True)
        count = len(local)
        band, mass = np.zeros((degree + 1, count * degree + 1)), np.zeros(count * degree + 1)
        rows = band[:, :-1].reshape(degree + 1, count, degree)
        for k in range(1, degree + 1):
            rows[k, :, : degree + 1 - k] = np.diagonal(local, -k, 1, 2)
        diagonal = np.diagonal(local, 0, 1, 2) + self.mass * self.potential
        for whole, parts in ((band[0], diagonal), (mass, self.mass)):
            whole[:-1] += parts[:, :-1].ravel()
            whole[degree::degree] += parts[:, -1]
        band[0, -1] -= self.supply or 0.0
        root = np.sqrt(mass)
        for k in range(degree + 1):
            band[k, : len(root) - k] /= root[k:] * root[: len(root) - k]
        if self.supply is None:
            band, root = band[:, :-1].copy(), root[:-1]
            for k in range(1, degree + 1):
                band[k, len(root) - k :] = 0.0
        return band, root

    def _bound(self) -> float:
        """Less than every quotient: b phi(1)^2 <= int phi'^2 + (b^2 + b/length) int phi^2."""
        b, length = max(self.supply or 0.0, 0.0), float(self.mass.sum())
        least = float(self.potential.min()) - b * (b + 1.0 / length)
        return least - 1e-3 * abs(least)


def _shifted(band: np.ndarray, shift: float) -> np.ndarray:
    moved = band.copy()
    moved[0] -= shift
    return moved


def _product(band: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """The symmetric matrix of lower band `band`, times `vector`."""
    image = band[0] * vector
    for k in range(1, len(band)):
        image[k:] += band[k, :-k] * vector[:-k]
        image[:-k] += band[k, :-k] * vector[k:]
    return image
