"""The extended state: the steady state that depends on x alone.

With J = eps^(1/2) g, g = F dw/dxi, for the heat flux over p^(3/2) (see `uniform_pressure`), the equation
dJ/dxi = eps^(1/2) Q becomes one of first order in w, because it does not name xi. For G = g^2

    dG/dw + G = 2 F Q,    G(w0) = 0,    xi = int F dw/G^(1/2),    int n dxi = f length at xi = length

where w0 is w at the elastic wall. So the state is two quadratures, and w0 the root of one equation. Nothing in them
can overflow: e^w occurs only in functions that are smooth, and constant for w below -40 or so. With w = w0 + s^2 the
integrands are smooth at the elastic wall too: G = s^2 h(s), dxi = 2 F ds/h^(1/2).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial import legendre
from scipy.optimize import brentq

from hydro.errors import RunFailed
from hydro.gas.closure import described
from hydro.state import bounds
from hydro.steady.elements import evaluate, reference_element
from hydro.steady.uniform_pressure import UniformPressure
from hydro.walls import ThermalWall, VibratingWall

DEGREE = 14  # of the polynomials on each element
DENSE = -40.0  # below this w, 1-n cannot be told from 0 and the closure's functions are constant
RELAXED = 40.0  # e^-40 is lost in round-off: so far above w0, G has forgotten its start
FIRST = 0.25  # extent of the first element in w; the others extend over 1
STEPS = 60  # of any iteration
CLOSED = 1e-10  # what the box's length and mass may be off by, relatively


@dataclass(frozen=True)
class Profile:
    """w, xi and the mass int n dxi at the nodes of elements in s = (w - w0)^(1/2); all (elements, nodes)."""

    w0: float
    s: np.ndarray
    w: np.ndarray
    flux: np.ndarray  # g = F dw/dxi
    xi: np.ndarray
    xi_slope: np.ndarray  # dxi/ds
    mass: np.ndarray


@dataclass(frozen=True)
class ExtendedState:
    """The 1D state of a gas of mean density f between an elastic wall at x=0 and a driving wall at x=1.

    Its density does not depend on what kind of wall drives it. Scaled units; x in [0, 1] may be a number or an
    array, and results have its shape.
    """

    gas: Any
    f: float
    profile: Profile

    @property
    def w0(self) -> float:
        """w = log(1/n - 1/n_p) at x=0."""
        return self.profile.w0

    @property
    def length(self) -> float:
        """Length of the box in units of xi."""
        return UniformPressure.of(self.gas).length

    @property
    def degree(self) -> int:
        """Degree of the elements."""
        return self.profile.s.shape[1] - 1

    @property
    def x(self) -> np.ndarray:
        """Nodes, from 0 to 1."""
        return np.append(joined(self.profile.xi)[:-1] / self.length, 1.0)

    @property
    def w(self) -> np.ndarray:
        """w at the nodes."""
        return joined(self.profile.w)

    @property
    def wall_density(self) -> tuple[float, float]:
        """n at the elastic and at the driving wall."""
        n = UniformPressure.of(self.gas).density(np.array([self.w0, self.profile.w[-1, -1]]))
        return float(n[0]), float(n[1])

    def log_void_at(self, x):
        """w = log(1/n - 1/n_p)."""
        return self.profile.w0 + self._s_at(x) ** 2

    def density_at(self, x):
        """n."""
        return UniformPressure.of(self.gas).density(self.log_void_at(x))

    def temperature_at(self, x, wall: VibratingWall | ThermalWall):
        """T; near the elastic wall of a dense cluster it may be too small for a number, and is zero then."""
        return self.pressure(wall) * UniformPressure.of(self.gas).temperature(self.log_void_at(x))

    def pressure(self, wall: VibratingWall | ThermalWall) -> float:
        """The uniform pressure that the driving wall causes."""
        disks, w = UniformPressure.of(self.gas), float(self.profile.w[-1, -1])
        if isinstance(wall, ThermalWall):
            return float(wall.temperature / disks.temperature(w))
        # kappa dT/dx = conduction p^(3/2) eps^(1/2) g length is to be strength p^(1/2) eps^(1/2) H, Eq. (wall1)
        supply = wall.strength / disks.conduction * disks.wall_supply(w)
        return float(supply / (self.profile.flux[-1, -1] * disks.length))

    def knudsen_at(self, x, diameter: float):
        """Mean free path over the length on which T changes, for grains of the given diameter d/L_x.

        With 1-r^2 from L = (32/(3 gamma)) (1-r^2)/diameter^2 it is (1-r^2)^(1/2) times a number of order one.
        """
        disks, s = UniformPressure.of(self.gas), self._s_at(x)
        w = self.w0 + s**2
        gradient = disks.temperature_slope(w) * self._flux_at(s) / disks.conductance(w) * self.length
        return diameter * disks.gas.mean_free_path(disks.density(w)) * gradient

    def knudsen(self, diameter: float) -> float:
        """The largest Knudsen number in the box."""
        return float(np.max(self.knudsen_at(self.x, diameter)))

    def average(self, function: Callable[[np.ndarray], np.ndarray]) -> float:
        """Average over the box of a function of w."""
        profile, element = self.profile, reference_element(self.degree)
        half = 0.5 * np.ptp(profile.s, axis=1)[:, None]
        return float(np.sum(element.weights * half * profile.xi_slope * function(profile.w)) / self.length)

    def _s_at(self, x):
        """s, the root of xi(s) = x length, by Newton's method on the polynomials of the elements."""
        profile, element = self.profile, reference_element(self.degree)
        wanted = np.clip(np.ravel(np.asarray(x, dtype=float)) * self.length, 0.0, profile.xi[-1, -1])
        k = np.clip(np.searchsorted(profile.xi[:, 0], wanted, side="right") - 1, 0, len(profile.xi) - 1)
        xi = (profile.xi @ element.modes.T)[k]
        slope = (profile.xi_slope @ element.modes.T)[k] * (0.5 * np.ptp(profile.s, axis=1))[k, None]
        r = 2.0 * (wanted - profile.xi[k, 0]) / (profile.xi[k, -1] - profile.xi[k, 0]) - 1.0
        for _ in range(STEPS):
            change = (evaluate(xi, r) - wanted) / evaluate(slope, r)
            r = np.clip(r - change, -1.0, 1.0)
            if np.all(np.abs(change) < 1e-13):
                break
        s = profile.s[k, 0] + 0.5 * (1.0 + r) * (profile.s[k, -1] - profile.s[k, 0])
        return s.reshape(np.shape(x))

    def _flux_at(self, s):
        """g at s."""
        profile, element = self.profile, reference_element(self.degree)
        flat = np.ravel(s)
        k = np.clip(np.searchsorted(profile.s[:, 0], flat, side="right") - 1, 0, len(profile.s) - 1)
        r = 2.0 * (flat - profile.s[k, 0]) / (profile.s[k, -1] - profile.s[k, 0]) - 1.0
        return evaluate((profile.flux @ element.modes.T)[k], r).reshape(np.shape(s))


def joined(values: np.ndarray) -> np.ndarray:
    """(elements, nodes) in one row, nodes that neighbours share once."""
    return np.append(values[:, :-1].ravel(), values[-1, -1])


def extended_state(gas: Any, f: float, degree: int = DEGREE, near: ExtendedState | None = None) -> ExtendedState:
    """The extended state of mean density f, below that of packing, of a gas that loses energy in collisions.

    `near` is a state close to it, if one is known. RunFailed, with what was tried, when no state is found.
    """
    disks = UniformPressure.of(gas)
    if not (0.0 < f < gas.packing_density() and 0.0 < disks.loss * disks.gas.cooling_factor(f) < math.inf):
        needs = f"it needs losses in collisions and a mean density in {bounds(gas)}"
        raise RunFailed(f"no extended state for {described(gas)}, f = {f:g}: {needs}")
    search = Search(disks, f, degree)
    with np.errstate(all="ignore"):  # what is not a number fails below
        profile = search.profile(search.root(None if near is None else near.w0))
    length, mean = profile.xi[-1, -1] / search.length - 1.0, profile.mass[-1, -1] / (f * search.length) - 1.0
    if not max(abs(length), abs(mean)) <= CLOSED:
        raise RunFailed(
            f"no extended state for {described(gas)}, f = {f:g}: best is w = {profile.w0:.6g} at x=0, "
            f"where the box's length is off by {length:.1e} and its mass by {mean:.1e}"
        )
    return ExtendedState(gas, f, profile)


class Search:
    """Looks for the w0 at which the box of given length holds the given mass."""

    def __init__(self, disks: UniformPressure, f: float, degree: int):
        self.disks, self.f, self.length, self.degree = disks, f, disks.length, degree
        self.tried: list[float] = []

    def root(self, guess: float | None) -> float:
        """w0. The mass falls as w0 rises: the densest place is x=0, so n(0) >= f bounds it from above."""
        high = math.log(1.0 / self.f - 1.0 / self.disks.gas.packing_density())
        low = above = min(high, high - 1.0 if guess is None else guess)
        step = 1e-3 * max(1.0, abs(low))
        while self.excess(above) > 0.0:
            if above == high:  # uniform but for round-off
                return high
            low, above, step = above, min(high, above + step), 4.0 * step
        while low == above or self.excess(low) <= 0.0:
            low, above, step = low - step, low, 4.0 * step
            if len(self.tried) > STEPS:
                raise RunFailed(
                    f"no extended state for a box of length {self.length:g} and f = {self.f:g}: "
                    f"tried w at x=0 from {min(self.tried):.6g} to {max(self.tried):.6g}"
                )
        return brentq(self.excess, low, above, xtol=1e-15, rtol=4.0 * np.finfo(float).eps, maxiter=200)

    def excess(self, w0: float) -> float:
        """Logarithm of the mass in the box over the wanted one."""
        self.tried.append(w0)
        profile = self._beyond(w0)
        mass = self._at_wall(profile, profile.mass)
        if not 0.0 < mass < math.inf:
            raise RunFailed(f"no extended state from w = {w0:.6g} at x=0: the box would hold a mass of {mass}")
        return math.log(mass / (self.f * self.length))

    def profile(self, w0: float) -> Profile:
        """The profile whose last element ends at the driving wall."""
        trial = self._beyond(w0)
        end = self._at_wall(trial) ** 2
        ends = trial.s[:, 0] ** 2
        ends = ends[ends < end]
        if len(ends) > 1 and end - ends[-1] < 0.2 * (ends[-1] - ends[-2]):
            ends = ends[:-1]
        return integrate(self.disks, w0, np.append(ends, end), self.degree)

    def _beyond(self, w0: float) -> Profile:
        """The profile from w0 up to somewhere behind the driving wall."""
        top = max(math.log1p(self.length), w0) + 2.0
        for _ in range(STEPS):
            profile = integrate(self.disks, w0, self._extents(w0, top), self.degree)
            if profile.xi[-1, -1] >= self.length:
                return profile
            top += 5.0
        raise RunFailed(
            f"no extended state from w = {w0:.6g} at x=0: followed to {top:.6g}, where "
            f"{profile.xi[-1, -1]:.6g} of the box's length {self.length:.6g} is filled"
        )

    def _extents(self, w0: float, top: float) -> np.ndarray:
        """Ends of the elements in w - w0, from 0 to top - w0 or somewhat more."""
        uniform = self.length**2 * float(self.disks.cooling(w0) / (2.0 * self.disks.conductance(w0)))
        first = min(FIRST, 2.0 * uniform)  # nearly uniform states lie within an element that is made for them
        fine = [0.0, first, FIRST] if first < FIRST else [0.0, FIRST]
        if DENSE - w0 < RELAXED + 1.0:
            return np.concatenate([fine, np.arange(1.0, top - w0 + 1.0)])
        return np.concatenate([fine, np.arange(1.0, RELAXED + 1.0), np.arange(DENSE, top + 1.0) - w0])

    def _at_wall(self, profile: Profile, values: np.ndarray | None = None) -> float:
        """s at the driving wall, or the value there of what `values` holds at the nodes."""
        element = reference_element(self.degree)
        k = min(int(np.searchsorted(profile.xi[:, 0], self.length, side="right")), len(profile.xi)) - 1
        half = 0.5 * (profile.s[k, -1] - profile.s[k, 0])
        xi, slope = element.modes @ profile.xi[k], element.modes @ profile.xi_slope[k] * half
        r = 2.0 * (self.length - profile.xi[k, 0]) / (profile.xi[k, -1] - profile.xi[k, 0]) - 1.0
        for _ in range(STEPS):
            change = float((legendre.legval(r, xi) - self.length) / legendre.legval(r, slope))
            r = min(max(r - change, -1.0), 1.0)
            if abs(change) < 1e-14:
                break
        if values is not None:
            return float(legendre.legval(r, element.modes @ values[k]))
        return float(profile.s[k, 0] + half * (1.0 + r))


def integrate(disks: UniformPressure, w0: float, extents: np.ndarray, degree: int) -> Profile:
    """The profile that starts from w0, on elements between `extents`, increasing values of w - w0 from 0."""
    element = reference_element(degree)
    ends = np.sqrt(extents)
    half = 0.5 * np.diff(ends)[:, None]
    s = ends[:-1, None] + half * (1.0 + element.nodes)
    w = w0 + s**2
    conductance = disks.conductance(w)
    source = 2.0 * conductance * disks.cooling(w)
    h = _relaxed(source, s, half, extents)
    h[1:] /= s[1:] ** 2
    h[0] = _first(disks, w0, s[0])
    root = np.sqrt(h)
    xi_slope = 2.0 * conductance / root
    return Profile(
        w0, s, w, root * s, _cumulative(xi_slope * half, element.integral), xi_slope,
        _cumulative(disks.density(w) * xi_slope * half, element.integral),
    )  # fmt: skip


def _cumulative(values: np.ndarray, integral: np.ndarray) -> np.ndarray:
    """Integrals from the first node to every node; `values` already hold the scale of their element."""
    inside = values @ integral.T
    before = np.concatenate([[0.0], np.cumsum(inside[:-1, -1])])
    return before[:, None] + inside


def _first(disks: UniformPressure, w0: float, s: np.ndarray) -> np.ndarray:
    """G/s^2 on the first element, the mean of 2 F Q e^(w'-w) over w0 < w' < w: to all digits however small s is."""
    nodes, weights = legendre.leggauss(12)
    u = 0.5 * (1.0 + nodes)
    t = s[:, None] ** 2
    w = w0 + t * u
    return (2.0 * disks.conductance(w) * disks.cooling(w) * np.exp(-t * (1.0 - u))) @ (0.5 * weights)


def _relaxed(source: np.ndarray, s: np.ndarray, half: np.ndarray, extents: np.ndarray) -> np.ndarray:
    """G at the nodes: dG/dw + G = source, from element to element."""
    element = reference_element(s.shape[1] - 1)
    flat = np.diff(extents) > 1.5  # there the source is constant and G has come to it
    risen = np.where(flat[:, None], 0.0, s**2 - extents[:-1, None])
    growth = np.exp(risen)
    inside = (growth * source * 2.0 * s * half) @ element.integral.T / growth
    inside[flat] = source[flat]
    decay = np.where(flat, 0.0, np.exp(-np.diff(extents)))
    start, now = [], 0.0
    for kept, gained in zip(decay.tolist(), inside[:, -1].tolist(), strict=True):
        start.append(now)
        now = kept * now + gained
    fade = np.where(flat[:, None], 0.0, 1.0 / growth)
    return np.array(start)[:, None] * fade + inside
