"""What every closure of a gas of nearly elastic hard disks shares.

Hard disks have no energy scale of their own, so temperature enters only by power laws:

    p = n T Z(n),    kappa = k(n) T^(1/2),    I = q(n) T^(3/2)

Toward the density n_p at which the gas packs, the gaps between disks vanish, and Z, k and q diverge like one over
gap = 1 - n/n_p. A closure gives n_p, the factors gap Z, gap k and gap q, which are smooth up to n = n_p, and their
slopes in n; all else follows here. Steady states use the factors themselves: their gap may be far below what n can
resolve. A closure that never packs has n_p = inf and gap = 1.

Which constants a closure has is its own affair: nobody else reads them.

Viscosities are those that kinetic theory gives for the conductivity. With y = Z - 1, Enskog's theory of elastic disks
(Gass, J. Chem. Phys. 54, 1898, 1971; the elastic limit of Jenkins and Richman, Phys. Fluids 28, 3485, 1985) has

    kappa = 2 (T/pi)^(1/2)/(d chi)     (1 + 3y/2 + (9/16 + 1/pi) y^2)
    eta   = (T/pi)^(1/2)/(2 d chi)     (1 + y + (1/4 + 2/pi) y^2)          shear
    zeta  = (T/pi)^(1/2)/(2 d chi)     (4/pi) y^2                          bulk

with chi the contact value of the pair correlation. Only ratios of these are used here.

Scaled units: density n_c, length L_x, temperature T_*.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import numpy as np

# Weights of y in the formulas above.
CONDUCTIVE, SHEAR, BULK = 9.0 / 16.0 + 1.0 / math.pi, 0.25 + 2.0 / math.pi, 4.0 / math.pi


class Closure(Protocol):
    """What solvers ask of a gas. A new closure derives from a NamedTuple of its constants and from `HardDisks`,
    and gives the methods that are listed first; all take and return numbers or arrays of one shape.

    The constants are keys of the section [gas] in decks, by their names and types.
    """

    def packing_density(self) -> float: ...  # n_p, where Z diverges; inf where it does not
    def pressure_factor(self, n): ...  # gap Z
    def pressure_factor_slope(self, n): ...  # d/dn of it
    def density(self, p, T): ...  # n(p, T)
    def mean_free_path(self, n): ...  # over the grain diameter
    def conductivity_factor(self, n): ...  # gap k
    def conductivity_factor_slope(self, n): ...
    def cooling_factor(self, n): ...  # gap q
    def cooling_factor_slope(self, n): ...

    def _asdict(self) -> dict[str, float]: ...  # its constants, by name

    # These have defaults in `HardDisks` that a closure may replace.
    def conducts(self) -> bool: ...
    def reduced(self) -> Reduced: ...
    def parameters(self) -> tuple[str, ...]: ...
    def with_parameter(self, name: str, value: float) -> Closure: ...

    def gap(self, n): ...
    def compressibility(self, n): ...
    def compressibility_slope(self, n): ...
    def conductivity_coefficient(self, n): ...
    def conductivity_coefficient_slope(self, n): ...
    def cooling_coefficient(self, n): ...
    def cooling_coefficient_slope(self, n): ...
    def pressure(self, n, T): ...
    def pressure_slopes(self, n, T): ...
    def density_slopes(self, n, T): ...
    def temperature(self, n, p): ...
    def adiabatic_exponent(self, n): ...
    def sound_speed(self, n, T): ...
    def sound_speed_at_pressure(self, n, p): ...
    def conductivity(self, n, T): ...
    def conductivity_slopes(self, n, T): ...
    def viscosities(self, n, T): ...
    def cooling(self, n, T): ...
    def cooling_slopes(self, n, T): ...


def described(gas: Closure) -> str:
    """The parameters of a gas and their values in words; its constants where it has no parameters."""
    values = gas._asdict()
    return ", ".join(f"{name} = {values[name]:g}" for name in gas.parameters() or values)


class Reduced(NamedTuple):
    """A gas whose kappa is `conduction`, and whose I is `conduction` times `loss`, times those of `gas`.

    At uniform pressure its steady densities are those of `gas` in a box that is loss^(1/2) times as long.
    """

    gas: Any
    conduction: float
    loss: float


class HardDisks:
    """Thermodynamics and derivatives that follow from a closure's factors.

    All arguments and results are scalars or arrays of one shape, in scaled units. Nothing is checked:
    outside 0 < n < n_p, T > 0 the results have no meaning.
    """

    _replace: Callable  # of the NamedTuple
    packing_density: Callable
    pressure_factor: Callable
    pressure_factor_slope: Callable
    conductivity_factor: Callable
    conductivity_factor_slope: Callable
    cooling_factor: Callable
    cooling_factor_slope: Callable

    def conducts(self):
        """Whether heat is conducted at all; without it no heat comes from walls, and none is lost in collisions."""
        return bool(self.conductivity_coefficient(0.5 * min(self.packing_density(), 1.0)) > 0.0)

    def reduced(self):
        """The gas without factors of its conduction and cooling that only set scales: here, none are known."""
        return Reduced(self, 1.0, 1.0)

    def parameters(self):
        """Names of the constants that a branch of steady states may be followed in."""
        return ()

    def with_parameter(self, name, value):
        """The same gas with another value of one of its `parameters`."""
        return self._replace(**{name: value})

    def gap(self, n):
        """1 - n/n_p."""
        return 1.0 - n / self.packing_density()

    def compressibility(self, n):
        """Z = p/(n T)."""
        return self.pressure_factor(n) / self.gap(n)

    def compressibility_slope(self, n):
        """dZ/dn."""
        return (self.pressure_factor_slope(n) + self.compressibility(n) / self.packing_density()) / self.gap(n)

    def conductivity_coefficient(self, n):
        """k = kappa/T^(1/2)."""
        return self.conductivity_factor(n) / self.gap(n)

    def conductivity_coefficient_slope(self, n):
        """dk/dn."""
        dense = self.conductivity_coefficient(n) / self.packing_density()
        return (self.conductivity_factor_slope(n) + dense) / self.gap(n)

    def cooling_coefficient(self, n):
        """q = I/T^(3/2)."""
        return self.cooling_factor(n) / self.gap(n)

    def cooling_coefficient_slope(self, n):
        """dq/dn."""
        return (self.cooling_factor_slope(n) + self.cooling_coefficient(n) / self.packing_density()) / self.gap(n)

    def pressure(self, n, T):
        """p(n, T), Eq. (state)."""
        return n * T * self.compressibility(n)

    def pressure_slopes(self, n, T):
        """(dp/dn, dp/dT) at fixed T and at fixed n."""
        return T * (self.compressibility(n) + n * self.compressibility_slope(n)), n * self.compressibility(n)

    def density_slopes(self, n, T):
        """(dn/dp, dn/dT) at fixed T and at fixed p."""
        p_n, p_T = self.pressure_slopes(n, T)
        return 1.0 / p_n, -p_T / p_n

    def temperature(self, n, p):
        """T(n, p), Eq. (state) solved for T."""
        return p / (n * self.compressibility(n))

    def adiabatic_exponent(self, n):
        """n c^2 / p at constant entropy, for an internal energy T per grain (two translational degrees)."""
        Z = self.compressibility(n)
        return 1.0 + n * self.compressibility_slope(n) / Z + Z

    def sound_speed(self, n, T):
        """Adiabatic sound speed c(n, T)."""
        return np.sqrt(T * self.compressibility(n) * self.adiabatic_exponent(n))

    def sound_speed_at_pressure(self, n, p):
        """Adiabatic sound speed as a function of n and p."""
        return np.sqrt(p * self.adiabatic_exponent(n) / n)

    def conductivity(self, n, T):
        """Thermal conductivity kappa(n, T)."""
        return self.conductivity_coefficient(n) * np.sqrt(T)

    def conductivity_slopes(self, n, T):
        """(dkappa/dn, dkappa/dT)."""
        return self.conductivity_coefficient_slope(n) * np.sqrt(T), 0.5 * self.conductivity_coefficient(n) / np.sqrt(T)

    def viscosities(self, n, T):
        """(shear, bulk) viscosity: the conductivity times the ratios of kinetic theory, 0.21 to 0.25 and 0 to 0.36."""
        gap = self.gap(n)
        y = self.pressure_factor(n) - gap  # gap (Z-1)
        unit = 0.25 * self.conductivity(n, T) / (gap * gap + 1.5 * gap * y + CONDUCTIVE * y * y)
        return unit * (gap * gap + gap * y + SHEAR * y * y), unit * BULK * y * y

    def cooling(self, n, T):
        """Energy lost in collisions per unit area and time, I(n, T)."""
        return self.cooling_coefficient(n) * T * np.sqrt(T)

    def cooling_slopes(self, n, T):
        """(dI/dn, dI/dT)."""
        return self.cooling_coefficient_slope(n) * T * np.sqrt(T), 1.5 * self.cooling_coefficient(n) * np.sqrt(T)
