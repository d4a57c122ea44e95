"""hydro: time-dependent compressible granular hydrodynamics."""

__version__ = "0.1.0"
