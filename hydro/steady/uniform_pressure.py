"""A gas at uniform pressure, by the one unknown w = log(n_c/n - 1).

At uniform pressure p, T = p theta(n) with theta = 1/(n Z). Near close packing 1-n may be far below the smallest
number, so w is the unknown: with eps = e^w, n = 1/(1+eps) and 1-n = eps n. A closure's smooth factors (1-n) Z,
(1-n) k and (1-n) q, here Zf, kf and qf, leave of the singular terms one factor eps^(1/2), the same in all of them:

    kappa grad T = p^(3/2) eps^(1/2) F(w) grad w,    F = kf Zf^(-3/2) (d log theta/dw)/n
    I            = p^(3/2) eps^(1/2) Q(w),           Q = qf Zf^(-3/2)/n
    n T^(1/2)    = p^(1/2) eps^(1/2) H(w),           H = n Zf^(-1/2)

F and Q are the paper's (z-1)^(1/2) F(z) and (z-1)^(-1/2) L Q(z), both times K (3/32)^(1/2). The equation
div(eps^(1/2) F grad w) = eps^(1/2) Q does not know K, and knows L only as the square of a length: all is computed for
K = L = 1, where the unit of length is L_x/L^(1/2), and xi = x L^(1/2).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy.special import expit  # e^w to all digits, or zero, for w far below zero


class UniformPressure(NamedTuple):
    """The functions of w of a closure; all take and return numbers or arrays of one shape."""

    gas: Any

    @classmethod
    def of(cls, gas: Any) -> UniformPressure:
        """For a closure with any K and L."""
        return cls(gas._replace(K=1.0, L=1.0))

    def density(self, w):
        """n."""
        return expit(-w)

    def temperature(self, w):
        """T/p = theta; its logarithm is w - log Zf."""
        return np.exp(w) / self.gas.pressure_factor(self.density(w))

    def temperature_slope(self, w):
        """d log theta/dw."""
        return 1.0 + self._pressure_slope(self.density(w), expit(w))

    def conductance(self, w):
        """F."""
        n = self.density(w)
        stretch = 1.0 + self._pressure_slope(n, expit(w))
        return self.gas.conductivity_factor(n) * self.gas.pressure_factor(n) ** -1.5 * stretch / n

    def cooling(self, w):
        """Q."""
        n = self.density(w)
        return self.gas.cooling_factor(n) * self.gas.pressure_factor(n) ** -1.5 / n

    def cooling_slope(self, w):
        """d log Q/dw."""
        n, void = self.density(w), expit(w)
        cooling = self.gas.cooling_factor_slope(n) / self.gas.cooling_factor(n)
        return void * (1.0 - n * cooling) + 1.5 * self._pressure_slope(n, void)

    def wall_supply(self, w):
        """H."""
        n = self.density(w)
        return n * self.gas.pressure_factor(n) ** -0.5

    def wall_supply_slope(self, w):
        """d log(eps^(1/2) H)/dw."""
        n = self.density(w)
        return n - 0.5 + 0.5 * self._pressure_slope(n, expit(w))

    def potential(self, w):
        """V of Eq. (phi), phi'' = (V + kappa^2) phi: (dI/dw)/(kappa dT/dw) = (dQ/dw + Q/2)/F."""
        return self.cooling(w) * (self.cooling_slope(w) + 0.5) / self.conductance(w)

    def _pressure_slope(self, n, void):
        """-d log Zf/dw."""
        return n * void * self.gas.pressure_factor_slope(n) / self.gas.pressure_factor(n)
