"""Elastic hard disks as Enskog's theory has them, as a closure: it works wherever that of the paper does."""

from __future__ import annotations

import math
from typing import NamedTuple

from hydro.gas import HardDisks
from hydro.gas.closure import Reduced
from hydro.grains.placement import CLOSE_PACKING
from hydro.methods import compiled_methods
from physics.bench import GAMMA

COVERED = math.pi / 4.0 * CLOSE_PACKING  # share of the area that disks cover at close packing
SONINE, MIXED = 1.029, 0.8718  # Gass, J. Chem. Phys. 54, 1898 (1971)
STEP = 1e-4


class EnskogConstants(NamedTuple):
    """Constants of the scaled equations for mu = 1: K is d/L_x."""

    L: float
    K: float


@compiled_methods
class Enskog(EnskogConstants, HardDisks):
    """Henderson's pressure and contact value, the conductivity of Gass, a loss of (1-r^2) T in a collision.

    Not for n above freezing, 0.77, where disks crystallize. Slopes are central differences.
    """

    __slots__ = ()

    def packing_density(self):
        """Further than it may be used."""
        return 1.0

    def reduced(self):
        """The gas with K = L = 1."""
        return Reduced(self._replace(K=1.0, L=1.0), self.K, self.L)

    def pressure_factor(self, n):
        """(1-n) Z."""
        phi = COVERED * n
        return (1.0 - n) * (1.0 + 0.125 * phi * phi) / ((1.0 - phi) * (1.0 - phi))

    def pressure_factor_slope(self, n):
        """d/dn of it."""
        return (self.pressure_factor(n + STEP) - self.pressure_factor(n - STEP)) / (2.0 * STEP)

    def density(self, p, T):
        """n(p, T) below 1, by bisection."""
        n, step = 0.0 * p, 0.5
        for _ in range(50):
            tried = n + step
            n = n + step * (tried * T * self.compressibility(tried) < p)
            step = 0.5 * step
        return n

    def contact_value(self, n):
        """Pair correlation at contact."""
        phi = COVERED * n
        return (1.0 - 0.4375 * phi) / ((1.0 - phi) * (1.0 - phi))

    def mean_free_path(self, n):
        """Over the diameter."""
        return 1.0 / (math.sqrt(8.0) * CLOSE_PACKING * n * self.contact_value(n))

    def conductivity_factor(self, n):
        """(1-n) k."""
        y, contact = 2.0 * COVERED * n, self.contact_value(n)
        return (
            (1.0 - n) * self.K * math.sqrt(3.0 / math.pi) * SONINE * (1.0 / contact + 1.5 * y + MIXED * y * y * contact)
        )

    def conductivity_factor_slope(self, n):
        """d/dn of it."""
        return (self.conductivity_factor(n + STEP) - self.conductivity_factor(n - STEP)) / (2.0 * STEP)

    def cooling_factor(self, n):
        """(1-n) q."""
        rate = math.sqrt(math.pi) * CLOSE_PACKING * 3.0 / 32.0 * GAMMA * self.contact_value(n)
        return (1.0 - n) * self.K * self.L * rate * n * n

    def cooling_factor_slope(self, n):
        """d/dn of it."""
        return (self.cooling_factor(n + STEP) - self.cooling_factor(n - STEP)) / (2.0 * STEP)
