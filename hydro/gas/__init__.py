"""The granular gas: equation of state, conductivity and cooling, one class per closure."""

from hydro.gas.closure import CLOSURES, Closure, HardDisks
from hydro.gas.grossman import Grossman

__all__ = ["CLOSURES", "Closure", "Grossman", "HardDisks"]
