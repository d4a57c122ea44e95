"""Time-dependent compressible granular hydrodynamics: limiters, Riemann solvers, heat operator, integrators."""

from hydro.dynamics.godunov import Godunov
from hydro.dynamics.integrator import INTEGRATORS, Integrator, StepRejected
from hydro.dynamics.lagrange import LagrangeRemap

__all__ = ["INTEGRATORS", "Godunov", "Integrator", "LagrangeRemap", "StepRejected"]
