"""Time-dependent compressible granular hydrodynamics: integrators, limiters, Riemann solvers."""

from hydro.dynamics.godunov import Godunov
from hydro.dynamics.integrator import Integrator
from hydro.dynamics.lagrange import LagrangeRemap
from hydro.errors import StepRejected

__all__ = ["Godunov", "Integrator", "LagrangeRemap", "StepRejected"]
