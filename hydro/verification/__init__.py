"""The verification book: what is claimed of the solvers, measured.

    closures            the closures against the functions of the paper
    extended            the extended state against shooting and against its limits
    marginal            critical aspect ratios, tongues, large L
    riemann_problems    shocks, contacts and rarefactions
    waves               smooth flow, flow at low Mach number, contacts that are carried along
    heat                cooling, conduction, friction, the driving wall
    manufactured        all terms together
    implicit            the implicit integrator
    steady              localized states, growth rates, branches
    viscosity           shear and bulk viscosity in both integrators
    free_cooling        shear layers and clusters of a gas that cools freely
    conservation        mass, energy, symmetries, rest

`python -m hydro verify [--full]` prints the book; its exit code is 5 if a claim fails.
"""

from hydro.verification import (  # noqa: F401, I001  imported in the order of the book: each enters its measurements
    closures,
    extended,
    marginal,
    riemann_problems,
    waves,
    heat,
    manufactured,
    conservation,
    implicit,
    steady,
    viscosity,
    free_cooling,
)
from hydro.verification.claims import MEASUREMENTS, Claim, Findings, Measurement, Table, topics

__all__ = ["MEASUREMENTS", "Claim", "Findings", "Measurement", "Table", "topics"]
