"""Reference solutions with a closed or implicit form, for tests of convergence. Scaled units throughout."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from hydro.exact.riemann import Isentrope, PrimitiveState, bisect
from hydro.state import bounds


class LinearMode(NamedTuple):
    """A perturbation exp(s t + i k x) of a uniform state at rest: growth rate s, amplitudes (dn, du, dv, dT), k."""

    rate: complex
    amplitudes: np.ndarray  # (4,), with |dn| = 1; of shear |dv| = 1
    wavenumber: float

    def fields(self, x, t: float) -> np.ndarray:
        """(dn, du, dv, dT) at the points x, the real parts: shape (4,) + x.shape."""
        wave = np.exp(self.rate * t + 1j * self.wavenumber * np.asarray(x, float))
        return np.multiply.outer(self.amplitudes, wave).real


def linear_modes(
    gas: Any, n: float, T: float, tau: float, wavenumber: float, viscosity: float = 0.0
) -> dict[str, LinearMode]:
    """Heat, sound to the right and shear in a gas with conduction, friction and viscosity, without cooling.

    dn' = -n ik du,  n du' = -ik (p_n dn + p_T dT) - n du/tau - (eta + zeta) k^2 du,  n dT' = -p ik du - kappa k^2 dT,
    n dv' = -n dv/tau - eta k^2 dv; `viscosity` is over that of the closure.
    """
    k, p, (p_n, p_T) = wavenumber, gas.pressure(n, T), gas.pressure_slopes(n, T)
    kappa, (eta, zeta) = gas.conductivity(n, T), gas.viscosities(n, T)
    along, across = (-1.0 / tau - viscosity * part * k * k / n for part in (eta + zeta, eta))
    matrix = np.array([
        [0.0, -1j * k * n, 0.0],
        [-1j * k * p_n / n, along, -1j * k * p_T / n],
        [0.0, -1j * k * p / n, -kappa * k * k / n],
    ])  # fmt: skip
    rates, vectors = np.linalg.eig(matrix)
    # Heat is carried without a frequency, sound has two of opposite sign.
    chosen = {"heat": int(np.argmin(abs(rates.imag))), "sound": int(np.argmin(rates.imag))}
    modes = {
        name: LinearMode(complex(rates[m]), np.insert(vectors[:, m] / abs(vectors[0, m]), 2, 0.0), k)
        for name, m in chosen.items()
    }
    return {**modes, "shear": LinearMode(complex(across), np.array([0.0, 0.0, 1.0, 0.0], complex), k)}


class AcousticMode(NamedTuple):
    """A linear right-going sound wave: amplitudes per unit dn/n0, all in phase, its speed and its frequency c k."""

    density: float
    velocity: float
    pressure: float
    speed: float
    frequency: float


def homogeneous_cooling(gas: Any, n, T0, t):
    """T(t) of a uniform gas at rest that starts at T0 (Haff's law): n dT/dt = -I, so T = T0/(1 + t/t_c)^2.

    The cooling time is t_c = 2 n/(q T0^(1/2)) with I = q T^(3/2). Scalars or arrays that broadcast.
    """
    return T0 / (1.0 + gas.cooling_coefficient(n) * np.sqrt(T0) * t / (2.0 * n)) ** 2


def conduction_mode_decay(gas: Any, n, T, wavenumber):
    """Rate kappa k^2/n at which a small cosine of temperature decays at fixed density, without cooling."""
    return gas.conductivity(n, T) * wavenumber**2 / n


def acoustic_eigenmode(gas: Any, n0: float, T0: float, wavenumber: float) -> AcousticMode:
    """The right-going sound wave of small amplitude: dn = n0, du = c, dp = n0 c^2 per unit dn/n0."""
    c = float(gas.sound_speed(n0, T0))
    return AcousticMode(n0, c, n0 * c * c, c, c * wavenumber)


@dataclass(frozen=True)
class SimpleWave:
    """A periodic right-going sound wave of finite amplitude, n = n0 (1 + amplitude sin(2 pi x/length)) at t = 0.

    The gas is isentropic, with temperature T0 where n = n0, and u is the integral of c dn/n from n0: every value of
    n travels at its own u + c, so n(x, t) = N(x - (u + c) t) until the crests overtake the troughs. Raises
    ValueError for densities not between 0 and that of packing, and for times outside 0 <= t < breaking_time.
    """

    gas: Any
    n0: float
    T0: float
    amplitude: float
    length: float = 1.0

    def __post_init__(self):
        lowest, highest = self._extremes
        if not 0.0 < lowest <= highest < self.gas.packing_density():
            raise ValueError(f"densities from {lowest} to {highest} are not inside {bounds(self.gas)}")

    @cached_property
    def isentrope(self) -> Isentrope:
        """The states that the wave passes through."""
        return Isentrope(self.gas, self.n0, self.gas.pressure(self.n0, self.T0), densest=self._extremes[1])

    @cached_property
    def breaking_time(self) -> float:
        """Time at which the first characteristics meet, -1/min d(u+c)/dx of the start, to about six digits."""
        x = np.linspace(0.0, self.length, 4097)
        steepest = np.diff(self._speed(self._start(x))).min() / (x[1] - x[0])
        return math.inf if steepest == 0.0 else float(-1.0 / steepest)

    def primitive(self, x, t: float) -> PrimitiveState:
        """(n, u, p) at the points x, arrays of the shape of x."""
        if not 0.0 <= t < self.breaking_time:
            raise ValueError(f"the wave is smooth for 0 <= t < {self.breaking_time:.6g}, not at t = {t}")
        x = np.asarray(x, float)
        slowest, fastest = self._speed(np.array(self._extremes))
        origin = bisect(lambda y: y + t * self._speed(self._start(y)), x, x - t * fastest, x - t * slowest)
        n = self._start(origin)
        return PrimitiveState(n, self._velocity(n), self.isentrope.pressure(n))

    def conserved(self, x, t: float) -> np.ndarray:
        """(n, n u, e) at the points x, shape (3,) + x.shape, with e = n T + n u^2/2."""
        n, u, p = self.primitive(x, t)
        return np.stack([n, n * u, n * (self.gas.temperature(n, p) + 0.5 * u * u)])

    @property
    def _extremes(self) -> tuple[float, float]:
        return self.n0 * (1.0 - abs(self.amplitude)), self.n0 * (1.0 + abs(self.amplitude))

    def _start(self, x):
        return self.n0 * (1.0 + self.amplitude * np.sin(2.0 * np.pi * x / self.length))

    def _velocity(self, n):
        return self.isentrope.escape_speed(n) - self.isentrope.escape_speed(self.n0)

    def _speed(self, n):
        return self._velocity(n) + self.isentrope.sound_speed(n)


@dataclass(frozen=True)
class DensityWave:
    """n = n0 (1 + amplitude sin(2 pi (x - velocity t)/length)) at uniform pressure, carried along unchanged."""

    gas: Any
    n0: float
    amplitude: float
    pressure: float
    velocity: float
    length: float = 1.0

    def conserved(self, x, t: float) -> np.ndarray:
        """(n, n u, e) at the points x, shape (3,) + x.shape."""
        phase = 2.0 * np.pi * (np.asarray(x, float) - self.velocity * t) / self.length
        n = self.n0 * (1.0 + self.amplitude * np.sin(phase))
        thermal = self.pressure / self.gas.compressibility(n)
        return np.stack([n, n * self.velocity, thermal + 0.5 * n * self.velocity**2])


def isobaric_profile(low: float, high: float, width: float, length: float = 1.0) -> Callable:
    """Periodic density profile n(x): `high` in the middle half of a box of the given length, `low` outside.

    The two walls at length/4 and 3 length/4 are tanh(2 (x - x_wall)/width) closely, made exactly periodic and
    reaching `low` and `high` exactly in the middles; width = 0 gives jumps.
    """
    steepness = length / (math.pi * width) if width > 0.0 else math.inf

    def profile(x):
        phase = -np.cos(2.0 * np.pi * np.asarray(x, float) / length)
        hat = np.sign(phase) if width == 0.0 else np.tanh(steepness * phase) / math.tanh(steepness)
        return 0.5 * (low + high) + 0.5 * (high - low) * hat

    return profile


def cell_averages(function: Callable, faces, points: int = 8) -> np.ndarray:
    """Averages of function(x) over the cells between `faces` (one more than cells), by Gauss-Legendre quadrature.

    `function` takes an array (cells, points) and returns it, or several of them, or stacked: (..., cells, points);
    the result is (..., cells). Exact for polynomials up to degree 2 points - 1; a jump must lie on a face.
    """
    faces = np.asarray(faces, float)
    nodes, weights = np.polynomial.legendre.leggauss(points)
    x = 0.5 * (faces[1:] + faces[:-1])[:, None] + 0.5 * np.diff(faces)[:, None] * nodes
    return 0.5 * np.asarray(function(x)) @ weights
