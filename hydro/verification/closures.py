"""The closures are those of the paper, written for a time-dependent flow in n and T.

The paper writes the steady state in z = 1/n, with functions F, G, H and Q of z. They follow from the closures
exactly: at constant pressure p = n T (1+n)/(1-n), with C = (3/32)^(1/2),

    kappa dT/dz = K C p^(3/2) F(z),    I = K C L p^(3/2) Q(z),    n T^(1/2) = p^(1/2) H(z),    H = F/G,

so that kappa dT/dx = K W n T^(1/2) at the vibrating wall becomes C p G(z) dz/dx = W.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from hydro.gas import Grossman
from hydro.verification.claims import Claim, Findings, Table, at_most, measurement

TOPIC = "Closures"
GAS = Grossman(L=5e4, K=2e-3)
STEP = 1e-30  # of complex-step derivatives, which lose no digits
A = 1.0 - math.sqrt(3.0 / 8.0)
C = math.sqrt(3.0 / 32.0)
ROUND_OFF = 1e-12  # 1/n - 1 alone loses three digits at n = 0.999


def densities() -> np.ndarray:
    """From 1e-4 to 0.999, denser toward both ends."""
    return np.concatenate([np.geomspace(1e-4, 0.5, 60), 1.0 - np.geomspace(0.5, 1e-3, 60)])


def paper_f(z, alpha):
    """Eq. (F)."""
    inner = alpha * z * (z - 1.0) + math.sqrt(32.0 / 3.0) * (z - A)
    return (z**2 + 2 * z - 1) * inner**2 / ((z - A) * (z - 1) ** 0.5 * z**1.5 * (z + 1) ** 2.5)


def paper_g(z, alpha):
    """Eq. (G)."""
    inner = alpha * z * (z - 1.0) + math.sqrt(32.0 / 3.0) * (z - A)
    return (z**2 + 2 * z - 1) * inner**2 / (z * (z - A) * (z - 1) * (z + 1) ** 2)


def paper_q(z):
    """Eq. (Q)."""
    return (z - A) * (z - 1) ** 0.5 / ((z + 1) ** 1.5 * z**0.5)


def complex_step(function: Callable, x: np.ndarray) -> np.ndarray:
    """d function/dx for an analytic function of an array."""
    return np.imag(function(x + 1j * STEP)) / STEP


def deviation(value, reference) -> float:
    """Largest relative difference."""
    return float(np.max(np.abs(value / reference - 1.0)))


@measurement(TOPIC, "F, G, H and Q of the paper")
def paper_functions(full: bool) -> Findings:
    """Largest relative deviation from the paper's functions, for n from 1e-4 to 0.999 and p from 1e-3 to 1e3."""
    n, p = (grid.ravel() for grid in np.meshgrid(densities(), np.geomspace(1e-3, 1e3, 7)))
    z = 1.0 / n.astype(np.longdouble)
    T = GAS.temperature(n, p)
    slope = complex_step(lambda z: GAS.temperature(1.0 / z, p), 1.0 / n)
    scale = GAS.K * C * p**1.5
    deviations = {
        "conductivity: kappa dT/dz = K C p^(3/2) F": deviation(
            GAS.conductivity(n, T) * slope, scale * paper_f(z, GAS.alpha)
        ),
        "cooling: I = K C L p^(3/2) Q": deviation(GAS.cooling(n, T), scale * GAS.L * paper_q(z)),
        "flux of the vibrating wall: n T^(1/2) = p^(1/2) H": deviation(
            n * np.sqrt(T), np.sqrt(p) * paper_f(z, GAS.alpha) / paper_g(z, GAS.alpha)
        ),
        "vibrating wall: kappa dT/dz/(K n T^(1/2)) = C p G": deviation(
            GAS.conductivity(n, T) * slope / (GAS.K * n * np.sqrt(T)), C * p * paper_g(z, GAS.alpha)
        ),
    }
    return Findings(tuple(at_most(TOPIC, name, "round-off", value, ROUND_OFF) for name, value in deviations.items()))


@measurement(TOPIC, "Derivatives and inverses")
def derivatives(full: bool) -> Findings:
    """Every derivative that Newton's methods use, against complex-step differences; the inverses of p(n, T).

    The sound speed is that of c^2 = (dp/dn)_T + (dp/dT)_n p/n^2, for an internal energy T per grain.
    """
    n, T = (grid.ravel() for grid in np.meshgrid(densities(), np.geomspace(1e-3, 1e2, 6)))
    p, (p_n, p_T) = GAS.pressure(n, T), GAS.pressure_slopes(n, T)
    claims: list[Claim] = []
    for name in ("pressure", "conductivity", "cooling"):
        function, slopes = getattr(GAS, name), getattr(GAS, f"{name}_slopes")(n, T)
        by_step = complex_step(lambda x: function(x, T), n), complex_step(lambda x: function(n, x), T)  # noqa: B023
        worst = max(deviation(slope, reference) for slope, reference in zip(slopes, by_step, strict=True))
        claims.append(at_most(TOPIC, f"derivatives of the {name} in n and T", "round-off", worst, ROUND_OFF))
    c = GAS.sound_speed(n, T)
    inverses = {
        "mean free path, derivative": deviation(GAS.mean_free_path_slope(n), complex_step(GAS.mean_free_path, n)),
        "density(pressure(n, T), T) = n": deviation(GAS.density(p, T), n),
        "temperature(n, pressure(n, T)) = T": deviation(GAS.temperature(n, p), T),
        "sound speed from T": deviation(c, np.sqrt(p_n + p_T * p / n**2)),
        "sound speed from p": deviation(GAS.sound_speed_at_pressure(n, p), c),
    }
    claims += [at_most(TOPIC, name, "round-off", value, ROUND_OFF) for name, value in inverses.items()]
    return Findings(tuple(claims), (sample(),))


def sample() -> Table:
    """The coefficients at a few densities."""
    rows = [
        (
            n, GAS.compressibility(n), GAS.mean_free_path(n), GAS.conductivity_coefficient(n) / GAS.K,
            GAS.cooling_coefficient(n) / (GAS.K * GAS.L), GAS.sound_speed(n, 1.0),
        )
        for n in (1e-4, 0.004, 0.0235, 0.1, 0.5, 0.76, 0.9, 0.99)
    ]  # fmt: skip
    header = ("n", "p/(nT)", "lambda/d", "kappa/(K T^(1/2))", "I/(K L T^(3/2))", "c/T^(1/2)")
    return Table("The closures at a few densities.", header, rows)
