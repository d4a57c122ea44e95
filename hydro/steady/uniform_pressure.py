"""A gas at uniform pressure, by the one unknown w = log(1/n - 1/n_p), n_p the density of packing.

At uniform pressure p, T = p theta(n) with theta = 1/(n Z). Near packing the gap 1 - n/n_p may be far below the smallest
number, so w is the unknown: with eps = e^w, n = 1/(1/n_p + eps) and the gap is eps n. A closure's smooth factors gap Z,
gap k and gap q, here Zf, kf and qf, leave of the singular terms one factor eps^(1/2), the same in all of them:

    kappa grad T = p^(3/2) eps^(1/2) F(w) grad w,    F = kf Zf^(-3/2) (d log theta/dw)/n
    I            = p^(3/2) eps^(1/2) Q(w),           Q = qf Zf^(-3/2)/n
    n T^(1/2)    = p^(1/2) eps^(1/2) H(w),           H = n Zf^(-1/2)

F and Q are the paper's (z-1)^(1/2) F(z) and (z-1)^(-1/2) L Q(z), both times K (3/32)^(1/2). A factor of both drops out
of the equation div(eps^(1/2) F grad w) = eps^(1/2) Q, and one of Q alone is the square of a length. So all is computed
for the closure's `reduced` gas, for the paper's that of K = L = 1, where the unit of length is L_x/loss^(1/2), and
xi = x loss^(1/2).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from hydro.gas.packing import density_at, gap_at


class UniformPressure(NamedTuple):
    """The functions of w of a closure; all take and return numbers or arrays of one shape."""

    gas: Any
    conduction: float
    loss: float

    @classmethod
    def of(cls, gas: Any) -> UniformPressure:
        """For a closure, reduced."""
        return cls(*gas.reduced())

    @property
    def length(self) -> float:
        """Length of the box in units of xi."""
        return math.sqrt(self.loss)

    def density(self, w):
        """n."""
        return density_at(self.gas, w)

    def temperature(self, w):
        """T/p = theta; its logarithm is w - log Zf."""
        return np.exp(w) / self.gas.pressure_factor(self.density(w))

    def temperature_slope(self, w):
        """d log theta/dw."""
        return 1.0 + self._pressure_slope(w)

    def conductance(self, w):
        """F."""
        n = self.density(w)
        return self.gas.conductivity_factor(n) * self.gas.pressure_factor(n) ** -1.5 * self.temperature_slope(w) / n

    def cooling(self, w):
        """Q."""
        n = self.density(w)
        return self.gas.cooling_factor(n) * self.gas.pressure_factor(n) ** -1.5 / n

    def cooling_slope(self, w):
        """d log Q/dw."""
        n = self.density(w)
        cooling = self.gas.cooling_factor_slope(n) / self.gas.cooling_factor(n)
        return gap_at(self.gas, w) * (1.0 - n * cooling) + 1.5 * self._pressure_slope(w)

    def wall_supply(self, w):
        """H."""
        n = self.density(w)
        return n * self.gas.pressure_factor(n) ** -0.5

    def wall_supply_slope(self, w):
        """d log(eps^(1/2) H)/dw."""
        return self.density(w) / self.gas.packing_density() - 0.5 + 0.5 * self._pressure_slope(w)

    def potential(self, w):
        """V of Eq. (phi), phi'' = (V + kappa^2) phi: (dI/dw)/(kappa dT/dw) = (dQ/dw + Q/2)/F."""
        return self.cooling(w) * (self.cooling_slope(w) + 0.5) / self.conductance(w)

    def _pressure_slope(self, w):
        """-d log Zf/dw."""
        n = self.density(w)
        return n * gap_at(self.gas, w) * self.gas.pressure_factor_slope(n) / self.gas.pressure_factor(n)
