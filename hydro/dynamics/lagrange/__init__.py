"""The implicit integrator: an implicit Lagrange stage and a MUSCL remap, taken together. A file for each stage.

In a Lagrange stage the faces move with the velocity that the new pressure gives them; the remap carries what the faces
have swept over (density, momentum and enthalpy, with limited slopes) from cell to cell. Doing one after the other
splits what balances in a slow flow, and is first order in time. Here both are parts of one conservative update

    (y_new - y_base)/h = H(y_ahead, y_new):

velocities of the faces, pressure, conduction, cooling, the heat of the walls and drag are those of the new state; the
swept profiles are those of `y_ahead`, extrapolated in time from the last two states. With the weights of the variable
second-order backward difference (BDF2; Hundsdorfer and Verwer, 2003, IV.4) it is second order, and as stiff a method
as backward Euler: sound that is not resolved dies. Steps are limited by the remap (no face crosses more than a share
`cfl` of a cell) and by the change that the extrapolation does not foresee (`tolerance`).

    integrator      the steps; workspace: their arrays; rows: arithmetic of rows
    extrapolation   what the last two states say of the new one, and how far that was wrong
    transport       what the faces sweep over, and the momentum that streams
    balance         what is missing in the balances of mass and energy of every cell
    jacobian        derivatives of the balances
    completion      the new state from pressure and temperature
    shocks          what is done where the gas is not smooth
    sound           whether the steps resolve the sound that is there

Stresses act, implicitly, on velocities that are found before the pressure is (see `hydro.terms.viscosity`).

Momentum lives on the faces, each component on those that it points through; that of a cell is the mean of its faces.
The unknowns are pressure and temperature of every cell; density follows from them and stays in its bounds. Newton's
equations, five points with two unknowns each, are solved by one multigrid cycle per iteration (see `multigrid`) under
exact residuals. What the iteration leaves of the sums over the box is made up for, so that mass and the books of energy
do not depend on how well it converged. (A last update in flux form would do so cell by cell, but multiplies the errors
of short waves by h kappa/dx^2, a thousand or more, every step.)

Kernels in which cells meet their neighbours are exact: those above and below count alike to the last bit, and a start
that is its own mirror image in y stays so. Only sums over the box are not.
"""

from hydro.dynamics.lagrange.integrator import LagrangeRemap

__all__ = ["LagrangeRemap"]
