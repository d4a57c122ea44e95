"""Exact solutions that the solvers are measured against.

    riemann      two uniform states side by side: shocks, contact, rarefactions, for any closure
    solutions    cooling, conduction and sound at small amplitude; a simple wave at finite amplitude; isobaric profiles

All quantities are scaled; ideal flow unless the function says otherwise.
"""

from hydro.exact.riemann import Isentrope, PrimitiveState, RiemannSolution, solve
from hydro.exact.solutions import (
    AcousticMode,
    SimpleWave,
    acoustic_eigenmode,
    cell_averages,
    conduction_mode_decay,
    homogeneous_cooling,
    isobaric_profile,
)

__all__ = [
    "AcousticMode",
    "Isentrope",
    "PrimitiveState",
    "RiemannSolution",
    "SimpleWave",
    "acoustic_eigenmode",
    "cell_averages",
    "conduction_mode_decay",
    "homogeneous_cooling",
    "isobaric_profile",
    "solve",
]
