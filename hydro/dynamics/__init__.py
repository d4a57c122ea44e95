"""Time-dependent compressible granular hydrodynamics: limiters, Riemann solvers, heat operator, integrators."""

from hydro.dynamics.godunov import Godunov
from hydro.dynamics.integrator import INTEGRATORS, Exchange, Integrator, StepRejected
from hydro.dynamics.lagrange import LagrangeRemap

__all__ = ["INTEGRATORS", "Exchange", "Godunov", "Integrator", "LagrangeRemap", "StepRejected"]
