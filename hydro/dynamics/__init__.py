"""Time-dependent compressible granular hydrodynamics: integrators, limiters, Riemann solvers."""

from hydro.dynamics.godunov import Godunov
from hydro.dynamics.integrator import INTEGRATORS, Integrator
from hydro.dynamics.lagrange import LagrangeRemap
from hydro.errors import StepRejected

__all__ = ["INTEGRATORS", "Godunov", "Integrator", "LagrangeRemap", "StepRejected"]
