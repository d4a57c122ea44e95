"""Slope limiters: how MUSCL chooses one slope from the differences to both neighbours."""

from __future__ import annotations

from typing import NamedTuple

from hydro.methods import compiled_methods


@compiled_methods
class GeneralizedMinmod(NamedTuple):
    """minmod(theta a, (a+b)/2, theta b): minmod for theta=1, monotonized central (MC) for theta=2.

    van Leer, J. Comput. Phys. 23, 276 (1977).
    """

    theta: float

    def limited(self, a, b):
        """The limited slope for one-sided differences a and b."""
        steepest = self.theta * min(abs(a), abs(b))
        size = min(0.5 * abs(a + b), steepest)
        return (size if a > 0.0 else -size) if a * b > 0.0 else 0.0


@compiled_methods
class VanLeer(NamedTuple):
    """The harmonic mean 2ab/(a+b) of like-signed differences: van Leer, J. Comput. Phys. 14, 361 (1974)."""

    tiny: float = 1e-300  # keeps 0/0 out of the flat state

    def limited(self, a, b):
        """The limited slope for one-sided differences a and b."""
        product = a * b
        return (2.0 * product if product > 0.0 else 0.0) / (a + b + (self.tiny if a + b >= 0.0 else -self.tiny))


MINMOD, MC, VAN_LEER = GeneralizedMinmod(1.0), GeneralizedMinmod(2.0), VanLeer()
