"""The granular gas: equation of state, conductivity and cooling, in one class per closure.

    CLOSURES    registry of closures by deck name
    HardDisks   what every closure of hard disks shares
"""

from hydro.gas.closure import CLOSURES, HardDisks
from hydro.gas.grossman import Grossman

__all__ = ["CLOSURES", "Grossman", "HardDisks"]
