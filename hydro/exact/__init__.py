"""Exact solutions that the solvers are measured against.

    riemann      two uniform states side by side: shocks, contact, rarefactions, for any closure
    solutions    cooling; conduction, sound and shear of small amplitude; a simple wave; isobaric profiles
    manufactured every term of the equations at once, by an added source

All quantities are scaled; ideal flow unless the function says otherwise.
"""

from hydro.exact.manufactured import Manufactured
from hydro.exact.riemann import Isentrope, PrimitiveState, RiemannSolution, solve
from hydro.exact.solutions import (
    AcousticMode,
    DensityWave,
    LinearMode,
    SimpleWave,
    acoustic_eigenmode,
    cell_averages,
    conduction_mode_decay,
    homogeneous_cooling,
    isobaric_profile,
    linear_modes,
)

__all__ = [
    "AcousticMode",
    "DensityWave",
    "Isentrope",
    "LinearMode",
    "Manufactured",
    "PrimitiveState",
    "RiemannSolution",
    "SimpleWave",
    "acoustic_eigenmode",
    "cell_averages",
    "conduction_mode_decay",
    "homogeneous_cooling",
    "isobaric_profile",
    "linear_modes",
    "solve",
]
