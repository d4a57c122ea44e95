"""Limits in which the extended state and its marginal stability have formulas, for the closures of Grossman et al.

High density, n_c - n << n_c: F and Q are constant and u = (z-1)^(1/2) = e^(w/2) obeys the linear d^2u/dx^2 = k^2 u.
Low density, n << n_c: F ~ z and Q ~ 1/z, Phi = z^(3/2) obeys d^2 Phi/dx^2 ~ Phi^(-1/3), and z is cosh^2 of a parameter
that grows with the mass between the elastic wall and x. Nothing here holds for other closures.
"""

from __future__ import annotations

import math

import numpy as np

from hydro.gas.grossman import LAMBDA, A, Grossman
from hydro.steady.uniform_pressure import UniformPressure

PAPER_ALPHA = 1.15
LARGE_LOSS = 144.83  # Delta_min L^(1/2) at large L, for that alpha
CLOSE_PACKED = -200.0  # a w at which n = 1 to all digits


def dense_rate(gas: Grossman) -> float:
    """k of d^2u/dx^2 = k^2 u, k^2 = L Q/(2F) at close packing; 0.2165 L^(1/2) for the paper's alpha and for any."""
    disks = UniformPressure.of(gas)
    return math.sqrt(gas.L * float(disks.cooling(CLOSE_PACKED) / (2.0 * disks.conductance(CLOSE_PACKED))))


def dense_log_void(gas: Grossman, w0: float, x):
    """w(x) = w0 + 2 log cosh(k x), of u = u(0) cosh(k x)."""
    kx = dense_rate(gas) * np.abs(x)
    return w0 + 2.0 * (kx + np.log1p(np.exp(-2.0 * kx)) - math.log(2.0))


def dense_start(gas: Grossman, f: float) -> float:
    """w at x=0 of a box that is dense everywhere: 1 - f = int u^2 dx = u(0)^2 (1/2 + sinh(2k)/(4k))."""
    k = dense_rate(gas)
    integral = math.log(0.5 + math.sinh(2.0 * k) / (4.0 * k)) if k < 300.0 else 2.0 * k - math.log(8.0 * k)
    return math.log1p(-f) - integral


def dilute_start(gas: Grossman, f: float) -> float:
    """log z at x=0 of a box that is dilute everywhere, z = (2L)^(1/2)/(alpha (theta + sinh(2 theta)/2)) at theta_1."""
    return math.log(math.sqrt(2.0 * gas.L) / gas.alpha) - log_reach(dilute_mass(gas, f))


def log_reach(theta: float) -> float:
    """log(theta + sinh(2 theta)/2), without overflow."""
    return math.log(theta + 0.5 * math.sinh(2.0 * theta)) if theta < 300.0 else 2.0 * theta - math.log(4.0)


def dilute_mass(gas: Grossman, f: float) -> float:
    """theta at x=1: f L^(1/2)/(2^(1/2) alpha)."""
    return f * math.sqrt(gas.L) / (math.sqrt(2.0) * gas.alpha)


def dilute_profile(gas: Grossman, f: float, points: int = 400) -> tuple[np.ndarray, np.ndarray]:
    """(x, n) of a box that is dilute everywhere, from x=0 to x=1.

    z = z(0) cosh^2 theta where theta = (L/2)^(1/2)/alpha times the mass between 0 and x, and x ~ theta +
    sinh(2 theta)/2: this is Phi = z^(3/2) of d^2 Phi/dx^2 = (3L/(2 alpha^2)) Phi^(-1/3).
    """
    theta = np.linspace(0.0, dilute_mass(gas, f), points)
    x = theta + 0.5 * np.sinh(2.0 * theta)
    return x / x[-1], 1.0 / (math.exp(dilute_start(gas, f)) * np.cosh(theta) ** 2)


def dilute_aspect_ratio(gas: Grossman, f: float) -> float | None:
    """Delta_1 before the vibrating wall for f << min(1, L^(-1/2)), Eq. (asymp); None where f <= f_1."""
    instability = gas.L**2 * f**4 / (3.0 * gas.alpha**4) - (1.0 + A) * gas.L * f**3 / gas.alpha**2
    return math.pi / math.sqrt(instability) if instability > 0.0 else None


def least_aspect_ratio(gas: Grossman) -> float | None:
    """The least Delta_1 of large L before the vibrating wall; None where it has not been computed, for other alpha."""
    return LARGE_LOSS / math.sqrt(gas.L) if gas.alpha == PAPER_ALPHA else None


def dilute_end(gas: Grossman) -> float:
    """f_1 = 3 alpha^2 (1+a)/L, where Eq. (asymp) ends: more dilute states are stable for every aspect ratio."""
    return 3.0 * gas.alpha**2 * (1.0 + A) / gas.L


def growth_of_least_fraction(gas: Grossman) -> float:
    """alpha/8^(1/2), the slope of f_min L^(1/2) in log L.

    The place of the mode fixes the cluster; what is added to the mass as the box grows is the gas before it, where
    n = alpha/(2^(1/2) xi).
    """
    return gas.alpha / math.sqrt(8.0)


def knudsen_factor(gas: Grossman, gamma: float) -> float:
    """Knudsen number over (1-r^2)^(1/2) in a dilute gas that has come far from its densest place.

    There l dT/dx/T = (d/L_x) L^(1/2) (3/32)^(1/2) 2^(1/2)/alpha, and (d/L_x) L^(1/2) = (32 (1-r^2)/(3 gamma))^(1/2):
    neither f nor L nor L_x/d is left. So hydrodynamics holds where 1-r^2 << 1, as the paper says.
    """
    return math.sqrt(32.0 / (3.0 * gamma)) * LAMBDA * math.sqrt(2.0) / gas.alpha


def grain_diameter(gas: Grossman, inelasticity: float, gamma: float) -> float:
    """d/L_x of grains with 1-r^2 = `inelasticity`, from L = (32/(3 gamma)) (L_x/d)^2 (1-r^2)."""
    return math.sqrt(32.0 * inelasticity / (3.0 * gamma * gas.L))
