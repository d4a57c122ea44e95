"""Small perturbations of a gas that cools uniformly: shear layers and clusters.

The gas has the temperature T(t) of Haff's law. Velocities are measured by its root, temperatures by itself, and time by
ds = T^(1/2) dt: the coefficients are then constant, for p = T p1(n), I = q(n) T^(3/2), and eta, zeta and kappa go like
T^(1/2). With n (1 + r), T (1 + h), T^(1/2) (w, z) along and across the wave vector, all times exp(sigma s + i k x):

    sigma r = -i k w
    sigma w = (q/2n - (eta + zeta) k^2/n) w - (i k/n) (n p1' r + p1 h)
    sigma h = -i k (p1/n) w - (kappa k^2/n) h - (q/n) ((Q - 1) r + h/2),        Q = dln q/dln n
    sigma z = (q/2n - eta k^2/n) z
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np


class CoolingMode(NamedTuple):
    """Growth rate sigma in s, and amplitudes (r, w, z, h); of clusters r = 1, of shear z = 1."""

    rate: complex
    amplitudes: np.ndarray


def scaled_time(gas: Any, n: float, T0: float, t: float) -> float:
    """s(t) = t_c T_0^(1/2) ln(1 + t/t_c) of a gas that has T0 at t = 0; see `homogeneous_cooling`."""
    rate = gas.cooling_coefficient(n) / (2.0 * n)
    return math.log1p(rate * math.sqrt(T0) * t) / rate


def cooling_modes(gas: Any, n: float, wavenumber: float, viscosity: float = 1.0) -> dict[str, CoolingMode]:
    """`clusters`, the heat mode, and `shear`, the vortices; `viscosity` is over that of the closure."""
    k, (eta, zeta), kappa = wavenumber, gas.viscosities(n, 1.0), gas.conductivity(n, 1.0)
    p, p_n, q = gas.pressure(n, 1.0), gas.pressure_slopes(n, 1.0)[0], gas.cooling_coefficient(n)
    driven, Q = 0.5 * q / n, n * gas.cooling_coefficient_slope(n) / q
    matrix = np.array([
        [0.0, -1j * k, 0.0],
        [-1j * k * p_n, driven - viscosity * (eta + zeta) * k * k / n, -1j * k * p / n],
        [-(q / n) * (Q - 1.0), -1j * k * p / n, -kappa * k * k / n - driven],
    ])  # fmt: skip
    rates, vectors = np.linalg.eig(matrix)
    slowest = int(np.argmin(np.abs(rates.imag) - 1e-9 * rates.real))  # sound has frequencies, heat has none
    r, w, h = vectors[:, slowest] / vectors[0, slowest]
    return {
        "clusters": CoolingMode(complex(rates[slowest]), np.array([r, w, 0.0, h])),
        "shear": CoolingMode(complex(driven - viscosity * eta * k * k / n), np.array([0.0, 0.0, 1.0, 0.0], complex)),
    }


def critical_wave_numbers(gas: Any, n: float, viscosity: float = 1.0) -> dict[str, float]:
    """Wave numbers below which the modes grow: k_s^2 = q/(2 eta), k_h^2 = q (Q - 1 - C/2)/(kappa C), C = dln p/dln n.

    Infinite where nothing holds a mode back, zero where it does not grow.
    """
    eta, kappa, q = gas.viscosities(n, 1.0)[0], gas.conductivity(n, 1.0), gas.cooling_coefficient(n)
    C = n * gas.pressure_slopes(n, 1.0)[0] / gas.pressure(n, 1.0)
    Q = n * gas.cooling_coefficient_slope(n) / q
    shear = math.sqrt(0.5 * q / (viscosity * eta)) if viscosity * eta > 0.0 else math.inf
    return {"shear": shear, "clusters": math.sqrt(max(q * (Q - 1.0 - 0.5 * C) / (kappa * C), 0.0))}
