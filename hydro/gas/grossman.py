"""The closures of Grossman, Zhou and Ben-Naim, Phys. Rev. E 55, 4200 (1997), as used in the paper."""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np
from pydantic import Field

from hydro.gas.closure import HardDisks, Reduced
from hydro.methods import compiled_methods
from hydro.schema import Positive

A = 1.0 - math.sqrt(3.0 / 8.0)  # the number a of Eq. (meanfree)
LAMBDA = math.sqrt(3.0 / 32.0)  # 1/(sqrt(8) n_c d^2): the mean free path over d is LAMBDA (1-n)/(n(1-an))


class GrossmanConstants(NamedTuple):
    """Constants of the scaled equations."""

    L: float  # collisional loss, (32/3 gamma) (L_x/d)^2 (1-r^2)
    K: float  # conduction, mu d/L_x
    alpha: Annotated[Positive, Field(description="weight of the mean free path in the heat conductivity")] = 1.15


@compiled_methods
class Grossman(GrossmanConstants, HardDisks):
    """Interpolation between the dilute gas and close packing: Eqs. (state) and (meanfree) and the text after them."""

    __slots__ = ()

    def packing_density(self):
        """Density at which the gas packs: n_c, the unit."""
        return 1.0

    def conducts(self):
        """Whether K > 0."""
        return self.K > 0.0

    def reduced(self):
        """The gas with K = L = 1."""
        return Reduced(self._replace(K=1.0, L=1.0), self.K, self.L)

    def parameters(self):
        """A branch may be followed in L."""
        return ("L",)

    def pressure_factor(self, n):
        """(1-n) Z = 1+n, Eq. (state)."""
        return 1.0 + n

    def pressure_factor_slope(self, n):
        """d/dn of (1-n) Z."""
        return 1.0

    def adiabatic_exponent(self, n):
        """n c^2 / p = 2(1+2n)/(1-n^2): the general expression, simplified."""
        return (2.0 + 4.0 * n) / ((1.0 - n) * (1.0 + n))

    def sound_speed_at_pressure(self, n, p):
        """c(n, p), with one division: it is the hottest line of the flow solver."""
        return np.sqrt(p * (2.0 + 4.0 * n) / (n * (1.0 - n) * (1.0 + n)))

    def density(self, p, T):
        """n(p, T) in (0, 1): the positive root of T n^2 + (p+T) n - p = 0, without cancellation."""
        return 2.0 * p / (p + T + np.sqrt((p + T) * (p + T) + 4.0 * p * T))

    def mean_free_path(self, n):
        """Mean free path over the grain diameter, Eq. (meanfree)."""
        return LAMBDA * (1.0 - n) / (n * (1.0 - A * n))

    def mean_free_path_slope(self, n):
        """d(mean free path)/dn."""
        return -LAMBDA * (1.0 - 2.0 * A * n + A * n * n) / (n * n * (1.0 - A * n) * (1.0 - A * n))

    def conductivity_factor(self, n):
        """(1-n) k, with k = K n (alpha lambda + 1)^2/lambda."""
        reach = self.alpha * self.mean_free_path(n) + 1.0
        return self.K / LAMBDA * n * n * (1.0 - A * n) * reach * reach

    def conductivity_factor_slope(self, n):
        """d/dn of (1-n) k."""
        reach = self.alpha * self.mean_free_path(n) + 1.0
        stretch = 2.0 * self.alpha * n * (1.0 - A * n) * self.mean_free_path_slope(n)
        return self.K / LAMBDA * n * reach * ((2.0 - 3.0 * A * n) * reach + stretch)

    def cooling_factor(self, n):
        """(1-n) q, with q = K (3L/32) n/lambda."""
        return self.K * self.L * 0.09375 / LAMBDA * n * n * (1.0 - A * n)

    def cooling_factor_slope(self, n):
        """d/dn of (1-n) q."""
        return self.K * self.L * 0.09375 / LAMBDA * n * (2.0 - 3.0 * A * n)
