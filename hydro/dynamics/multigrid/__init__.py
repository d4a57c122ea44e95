"""Multigrid for pairs of unknowns per cell, pressure and temperature, coupled to the four neighbours.

Rows are the balances of mass and of energy of a cell. What crosses a face, from a lower cell a to an upper one b, is

    mass:    M (P_b - P_a)
    energy:  H (P_b - P_a) + C (T_b - T_a) + drift,    drift = A_P P_a + B_P P_b + A_T T_a + B_T T_b;

it is added to the rows of b and taken from those of a. Coarser levels join two by two cells: local terms and drifts
add up, and so do M, H and C, times the ratio of the distances between centres. On every level a cycle smooths by two
block Jacobi sweeps with Chebyshev weights before and after the coarser ones (they treat mirror images alike, which
Gauss-Seidel does not), sums residuals up and interpolates corrections bilinearly; the coarsest level is solved
directly. From the second level down it is an F-cycle: coarser levels are visited again, by a V-cycle, for what the
first visit has left.

The cycle works in single precision: it improves a solution whose residuals are double. Its arithmetic is exact, in the
order written, in which mirror images in y are treated alike to the last bit.
"""

from hydro.dynamics.multigrid.hierarchy import Hierarchy
from hydro.dynamics.multigrid.stencil import (
    DRIFT_PA,
    DRIFT_PB,
    DRIFT_TA,
    DRIFT_TB,
    ENERGY_P,
    ENERGY_T,
    MASS,
    build_row,
)

__all__ = [
    "DRIFT_PA",
    "DRIFT_PB",
    "DRIFT_TA",
    "DRIFT_TB",
    "ENERGY_P",
    "ENERGY_T",
    "MASS",
    "Hierarchy",
    "build_row",
]
