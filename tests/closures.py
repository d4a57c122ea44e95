"""Closures for tests: the paper's gas in other units of density, and one that never packs."""

from __future__ import annotations

import math
from typing import NamedTuple

from hydro.gas import HardDisks
from hydro.gas.grossman import LAMBDA, A
from hydro.methods import compiled_methods

PACKED = 1.1


class RescaledConstants(NamedTuple):
    L: float
    K: float
    alpha: float = 1.15


@compiled_methods
class Rescaled(RescaledConstants, HardDisks):
    """The closure of Grossman, Zhou and Ben-Naim with densities, pressures and heat in units of n_c/PACKED."""

    __slots__ = ()

    def packing_density(self):
        return PACKED

    def parameters(self):
        return ("L",)

    def pressure_factor(self, n):
        return 1.0 + n / PACKED

    def pressure_factor_slope(self, n):
        return 1.0 / PACKED

    def density(self, p, T):
        p = p / PACKED
        return PACKED * 2.0 * p / (p + T + ((p + T) * (p + T) + 4.0 * p * T) ** 0.5)

    def mean_free_path(self, n):
        n = n / PACKED
        return LAMBDA * (1.0 - n) / (n * (1.0 - A * n))

    def conductivity_factor(self, n):
        reach = self.alpha * self.mean_free_path(n) + 1.0
        n = n / PACKED
        return PACKED * self.K / LAMBDA * n * n * (1.0 - A * n) * reach * reach

    def conductivity_factor_slope(self, n):
        reach = self.alpha * self.mean_free_path(n) + 1.0
        n = n / PACKED
        inner = 1.0 - A * n
        path_slope = -LAMBDA * (1.0 - 2.0 * A * n + A * n * n) / (n * n * inner * inner)
        return self.K / LAMBDA * n * reach * ((2.0 - 3.0 * A * n) * reach + 2.0 * self.alpha * n * inner * path_slope)

    def cooling_factor(self, n):
        n = n / PACKED
        return PACKED * self.K * self.L * 0.09375 / LAMBDA * n * n * (1.0 - A * n)

    def cooling_factor_slope(self, n):
        n = n / PACKED
        return self.K * self.L * 0.09375 / LAMBDA * n * (2.0 - 3.0 * A * n)


@compiled_methods
class Dilute(RescaledConstants, HardDisks):
    """p = n T, and a mean free path as of points: the dilute limit of the paper's closure, at all densities."""

    __slots__ = ()

    def packing_density(self):
        return math.inf

    def pressure_factor(self, n):
        return 1.0 + 0.0 * n

    def pressure_factor_slope(self, n):
        return 0.0 * n

    def density(self, p, T):
        return p / T

    def mean_free_path(self, n):
        return LAMBDA / n

    def conductivity_factor(self, n):
        reach = self.alpha * LAMBDA / n + 1.0
        return self.K / LAMBDA * n * n * reach * reach

    def conductivity_factor_slope(self, n):
        return 2.0 * self.K / LAMBDA * (n + self.alpha * LAMBDA)

    def cooling_factor(self, n):
        return self.K * self.L * 0.09375 / LAMBDA * n * n

    def cooling_factor_slope(self, n):
        return self.K * self.L * 0.09375 / LAMBDA * 2.0 * n
