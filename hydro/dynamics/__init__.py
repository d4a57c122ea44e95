"""Time-dependent compressible granular hydrodynamics: limiters, Riemann solvers, heat operator, integrators."""
