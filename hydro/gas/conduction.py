"""Heat conducted through a face between two cells, or between a cell and a wall: one formula for every solver.

    heat = (kappa_a + kappa_b)/2 (T_b - T_a) weight,    weight = length of the face over the distance of a and b

is the heat per time that flows from b to a. Its coefficient is the mean of those at both ends. A state that balances it
in one solver is therefore steady in all. Toward a wall, b is the wall face. Arguments are numbers or arrays of shapes
that fit each other, in scaled units; kernels may use these functions too.

A flux that density gradients drive too, q = -kappa grad T - mu grad n (Garzo and Dufty, Phys. Rev. E 59, 5895, 1999),
adds (mu_a + mu_b)/2 (n_b - n_a) weight to the heat and to the slopes what follows from it. It belongs into the
functions below, which then take the closure's mu and n beside kappa and T. The closures here have mu = 0.
"""

from __future__ import annotations

from hydro.methods import formula


@formula
def face_conductivity(kappa_a, kappa_b):
    """Coefficient of a face: the mean of those at both ends."""
    return 0.5 * (kappa_a + kappa_b)


@formula
def face_conductance(weight, kappa_a, kappa_b):
    """Conducted heat over the temperature difference: its slope in T_b, and minus its slope in T_a, at fixed kappa."""
    return 0.5 * weight * (kappa_a + kappa_b)


@formula
def conducted_heat(weight, kappa_a, kappa_b, T_a, T_b):
    """Heat per time that flows from b to a."""
    return face_conductance(weight, kappa_a, kappa_b) * (T_b - T_a)


@formula
def conducted_slope(weight, T_a, T_b):
    """Slope of the conducted heat in kappa_a, which is that in kappa_b too."""
    return 0.5 * weight * (T_b - T_a)
