"""The granular gas: equation of state, conductivity and cooling, one class per closure."""

from hydro.gas.closure import Closure, HardDisks
from hydro.gas.grossman import Grossman

__all__ = ["Closure", "Grossman", "HardDisks"]
