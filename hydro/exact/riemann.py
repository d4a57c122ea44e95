"""The Riemann problem of ideal flow, exactly, for any closure p = n T Z(n) with internal energy T per grain.

Two uniform states meet at x = 0. A wave runs into each; between the two waves pressure and velocity are uniform
and the density jumps at the contact. Across either wave the outward velocity changes by an amount that grows
with the star pressure p*; p* is where both sides agree (Toro, Riemann Solvers, ch. 4, there for the ideal gas).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import Chebyshev
from scipy.optimize import brentq

from hydro.state import bounds

DEGREE = 64  # of the Chebyshev series along an isentrope: reaches rounding, up to 1 - n/n_p = 1e-6 at least
ROUNDING = np.finfo(float).eps
COMPRESSION = 3.0 + 1e-9  # more than any shock compresses a gas with Z >= 1 that grows with n
FAINTEST = 1e-100  # star pressure, over the lower of the two pressures, that counts as vacuum
SLACK = 1e-9  # by which brackets are widened, so that rounding leaves the root inside
TIGHT = {"xtol": 1e-15, "rtol": 4 * ROUNDING}  # of brentq in a logarithm
NODES, WEIGHTS = np.polynomial.legendre.leggauss(20)


class PrimitiveState(NamedTuple):
    """Density, velocity and pressure of a uniform state, or arrays of them."""

    density: Any
    velocity: Any
    pressure: Any


class Isentrope:
    """States of one entropy: through (density, pressure), from vacuum up to the density `densest`.

    From dT/T = Z dn/n and du = c dn/n; both are integrated as Chebyshev series in r, n = n_p (1 - exp(-r^2)), or r^2
    where the gas never packs; in r they are smooth from vacuum (c ~ r) to packing. Methods take and return arrays of
    any shape. ValueError for a closure that is no ideal gas in the dilute limit: (Z-1)/n is then not smooth.
    """

    def __init__(self, gas: Any, density: float, pressure: float, densest: float | None = None):
        if abs(gas.compressibility(1e-12) - 1.0) > 1e-9:
            raise ValueError("the closure must have Z(0) = 1")
        self.gas, self._packed = gas, gas.packing_density()
        self._scale = gas.temperature(density, pressure) / density
        top, start = float(self._r(density if densest is None else densest)), float(self._r(density))
        self._log = self._integral(lambda n: (gas.compressibility(n) - 1.0) / n, top, start)
        self._flow = self._integral(lambda n: self.sound_speed(n) / n, top, 0.0)

    def temperature(self, n):
        """T at density n."""
        return self._scale * n * np.exp(self._log(self._r(n)))

    def pressure(self, n):
        """p at density n."""
        return self.gas.pressure(n, self.temperature(n))

    def sound_speed(self, n):
        """c at density n."""
        return self.gas.sound_speed(n, self.temperature(n))

    def escape_speed(self, n):
        """Integral of c dn/n from vacuum to n: the speed gained by expansion into vacuum."""
        return self._flow(self._r(n))

    def characteristic_speed(self, n):
        """u + c in a right-going simple wave, u measured from that of vacuum: grows with n."""
        return self.escape_speed(n) + self.sound_speed(n)

    def density(self, pressure: float, ahead: PrimitiveState) -> float:
        """n at a pressure below that of the state `ahead` on this isentrope.

        The adiabatic exponent is 2 or more where Z >= 1 grows with n, which bounds n from below.
        """
        low = ahead.density * math.sqrt(pressure / ahead.pressure) * (1.0 - SLACK)
        high = min(ahead.density * (1.0 + SLACK), densest(self.gas))

        def residual(log_n: float) -> float:
            return math.log(self.pressure(math.exp(log_n)) / pressure)

        return math.exp(brentq(residual, math.log(low), math.log(high), **TIGHT))

    def _r(self, n):
        """r(n): like sqrt(n) near vacuum, resolving 1 - n/n_p near packing."""
        return np.sqrt(n) if self._packed == math.inf else np.sqrt(-np.log1p(-n / self._packed))

    def _integral(self, integrand: Callable, top: float, start: float) -> Chebyshev:
        """The integral of integrand(n) dn as a series in r on [0, top], zero at r = start."""

        def in_r(r):
            if self._packed == math.inf:
                return 2.0 * r * integrand(r * r)
            return self._packed * 2.0 * r * np.exp(-r * r) * integrand(self._packed * -np.expm1(-r * r))

        return Chebyshev.interpolate(in_r, DEGREE, domain=[0.0, top]).integ(lbnd=start)


@dataclass(frozen=True)
class Wave:
    """The wave running into one of the two states; `side` is -1 for the left, +1 for the right one.

    `head` and `tail` are the velocities of its two edges, equal for a shock.
    """

    side: int
    ahead: PrimitiveState
    behind: PrimitiveState
    head: float
    tail: float
    isentrope: Isentrope | None

    @property
    def kind(self) -> str:
        """Either "shock" or "rarefaction"."""
        return "shock" if self.isentrope is None else "rarefaction"

    def sample(self, xi: np.ndarray) -> np.ndarray:
        """(density, velocity, pressure) at x/t = xi on this side of the contact, shape (3,) + xi.shape."""
        outward = self.side * xi
        ahead, behind = outward >= self.side * self.head, outward <= self.side * self.tail
        states = np.empty((3, *xi.shape))
        states[:, ahead] = np.reshape(self.ahead, (3, 1))
        states[:, behind & ~ahead] = np.reshape(self.behind, (3, 1))
        fan = ~(ahead | behind)
        if self.isentrope is not None and fan.any():
            states[:, fan] = self._fan(self.isentrope, outward[fan])
        return states

    def _fan(self, isentrope: Isentrope, outward: np.ndarray) -> np.ndarray:
        """Inside the fan: u + c = xi with u minus the escape speed constant, mirrored for the left wave."""
        vacuum = self.side * self.ahead.velocity - isentrope.escape_speed(self.ahead.density)
        low, high = np.full_like(outward, self.behind.density), np.full_like(outward, self.ahead.density)
        n = bisect(isentrope.characteristic_speed, outward - vacuum, low, high)
        return np.stack([n, self.side * (vacuum + isentrope.escape_speed(n)), isentrope.pressure(n)])


@dataclass(frozen=True)
class RiemannSolution:
    """Pressure and velocity between the two waves, and the waves; the star densities are in their `behind`."""

    pressure: float
    velocity: float
    left: Wave
    right: Wave

    def sample(self, xi) -> PrimitiveState:
        """The solution at x/t = xi: density, velocity and pressure, each of the shape of xi."""
        xi = np.asarray(xi, float)
        return PrimitiveState(*np.where(xi < self.velocity, self.left.sample(xi), self.right.sample(xi)))


def solve(gas: Any, left: PrimitiveState, right: PrimitiveState) -> RiemannSolution:
    """Solve the Riemann problem for the closure `gas`; scaled units, star state good to 1e-12 away from vacuum.

    Raises ValueError for densities not between 0 and n_p or pressures not above 0, when the two states part so fast
    that vacuum opens between them, and when they collide so hard that the closure allows no shock below n_p.
    """
    for state in (left, right):
        legal = 0.0 < state.density < gas.packing_density() and 0.0 < state.pressure < math.inf
        if not (legal and math.isfinite(state.velocity)):
            raise ValueError(f"not a state with {bounds(gas)} and pressure > 0: {state}")
    sides = [(state, Isentrope(gas, state.density, state.pressure)) for state in (left, right)]

    parting = right.velocity - left.velocity

    def mismatch(log_p: float) -> float:
        return parting + sum(_across(gas, *side, math.exp(log_p))[1] for side in sides)

    escape = sum(float(isentrope.escape_speed(state.density)) for state, isentrope in sides)
    if parting >= escape:
        raise ValueError(f"vacuum opens: the states part at {parting:.6g}, the gas follows up to {escape:.6g}")
    log_p = brentq(mismatch, *_bracket(mismatch, left.pressure, right.pressure), **TIGHT)
    pressure = math.exp(log_p)
    (n_left, gain_left), (n_right, gain_right) = (_across(gas, *side, pressure) for side in sides)
    velocity = 0.5 * (left.velocity - gain_left + right.velocity + gain_right)
    return RiemannSolution(
        pressure,
        velocity,
        _wave(gas, -1, *sides[0], PrimitiveState(n_left, velocity, pressure)),
        _wave(gas, +1, *sides[1], PrimitiveState(n_right, velocity, pressure)),
    )


def hugoniot_density(gas: Any, ahead: PrimitiveState, pressure: float) -> float:
    """Density behind a shock that runs into `ahead` and leaves the given, higher pressure behind.

    T1 - T0 = (p1 + p0)(1/n0 - 1/n1)/2 with T = p/(n Z) is linear in p1 at fixed n1; one root in n1 is left.
    Raises ValueError when it is not below n_p.
    """
    n0, p0 = ahead.density, ahead.pressure

    def residual(n: float) -> float:
        half = 0.5 * (n - n0) / (n * n0)
        return pressure * (_energy(gas, n) - half) - p0 * (_energy(gas, n0) + half)

    top = densest(gas) if gas.packing_density() < math.inf else COMPRESSION * n0
    if residual(top) > 0.0:
        packed = f"n = {gas.packing_density():g}"
        raise ValueError(f"no shock from density {n0} to pressure {pressure:.6g} ends below {packed}")
    return brentq(residual, n0, top, xtol=1e-300, rtol=4 * ROUNDING)


def shock_mass_flux(gas: Any, ahead: PrimitiveState, n: float, pressure: float) -> float:
    """Mass flux j through the shock from `ahead` to density n, pressure p: j^2 = (p-p0)/(1/n0-1/n).

    Written with the mean slope of T/p in 1/n, so that it goes over into n c as the shock gets weak, digits kept.
    """
    v0, v = 1.0 / ahead.density, 1.0 / n
    between = 1.0 / (0.5 * (v0 + v) + 0.5 * (v0 - v) * NODES)
    Z = gas.compressibility(between)
    slope = 0.5 * WEIGHTS @ (1.0 / Z + between * gas.compressibility_slope(between) / Z**2)
    return math.sqrt(pressure * (1.0 + slope) / (_energy(gas, ahead.density) + 0.5 * (v0 - v)))


def densest(gas: Any) -> float:
    """The largest number below the density of packing."""
    return math.nextafter(gas.packing_density(), 0.0)


def bisect(function: Callable, target: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """x in [low, high] where the elementwise growing `function` is `target`; arrays of one shape."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        below = function(middle) < target
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return 0.5 * (low + high)


def _energy(gas: Any, n: float) -> float:
    """Internal energy per grain over the pressure, 1/(n Z)."""
    return 1.0 / (n * gas.compressibility(n))


def _across(gas: Any, ahead: PrimitiveState, isentrope: Isentrope, pressure: float) -> tuple[float, float]:
    """Density behind the wave with this star pressure, and the outward velocity gained across it."""
    if pressure > ahead.pressure:
        n = hugoniot_density(gas, ahead, pressure)
        return n, (pressure - ahead.pressure) / shock_mass_flux(gas, ahead, n, pressure)
    n = isentrope.density(pressure, ahead)
    return n, float(isentrope.escape_speed(n) - isentrope.escape_speed(ahead.density))


def _wave(gas: Any, side: int, ahead: PrimitiveState, isentrope: Isentrope, behind: PrimitiveState) -> Wave:
    if behind.pressure > ahead.pressure:
        flux = shock_mass_flux(gas, ahead, behind.density, behind.pressure)
        speed = ahead.velocity + side * flux / ahead.density
        return Wave(side, ahead, behind, speed, speed, None)
    head, tail = (state.velocity + side * float(isentrope.sound_speed(state.density)) for state in (ahead, behind))
    return Wave(side, ahead, behind, head, tail, isentrope)


def _bracket(mismatch: Callable[[float], float], *pressures: float) -> tuple[float, float]:
    """Logarithms of pressures below and above p*, found by steps that double."""
    low, high, step = math.log(min(pressures)), math.log(max(pressures)), 0.5
    while mismatch(high) < 0.0:
        low, high, step = high, high + step, 2.0 * step
    step = 0.5
    while mismatch(low) > 0.0:
        low, step = low - step, 2.0 * step
        if low < math.log(min(pressures)) + math.log(FAINTEST):
            raise ValueError("vacuum opens: the star pressure is too small to be represented")
    return low, high
