"""The explicit integrator: Godunov's method of second order, super-time-stepping for heat and viscosity."""

from hydro.dynamics.godunov.integrator import Godunov

__all__ = ["Godunov"]
