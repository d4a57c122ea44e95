"""Growth rates of a viscous gas: its linearized equations with the velocities on the faces as unknowns.

    dn'/dt    = -div(n v)
    de'/dt    = -div(h n v) + (div(kappa grad T) - I)'
    d(nv)/dt  = -grad p' + div sigma - n v/tau

at a state at rest, where viscous heating is of second order. Viscosities are those of the closure, times a factor, and
the force is that of `hydro.terms.viscosity.stress`: minus the derivative of half the dissipated power with respect to
the velocities. Shear, which viscosity damps by its shape, is among the modes. A motion along y that does not depend on
y is left out.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from hydro.state import State
from hydro.steady.operators import diagonal
from hydro.steady.spectrum import Linearized, Sector


class ViscousLinearization(Linearized):
    """What flows is the momentum of the faces in x, then of those in y. factor: over the viscosities of the closure."""

    def __init__(self, state: State, wall: Any, tau: float, sector: Sector, factor: float):
        super().__init__(state, wall, tau, sector)
        self.factor = factor

    @cached_property
    def stress(self) -> sparse.csr_array:
        """Forces per area on the faces from their velocities."""
        grid = self.staggered
        eta, zeta = (self.factor * each for each in self.state.gas.viscosities(self.n, self.T))
        strains = sparse.block_array([[grid.stretch[0], None], [None, grid.stretch[1]], list(grid.shear)])
        along, aside = grid.areas * (zeta + eta), grid.areas * (zeta - eta)
        sheared = grid.corner_areas * (grid.corner @ eta)
        stiffness = sparse.block_array(
            [
                [diagonal(along), diagonal(aside), None],
                [diagonal(aside), diagonal(along), None],
                [None, None, diagonal(sheared)],
            ]
        )
        power = strains.T @ stiffness @ strains
        return -diagonal(1.0 / np.concatenate(grid.face_areas)) @ power

    @cached_property
    def matrix(self) -> sparse.csr_array:
        grid, (p_n, p_e), (heat_n, heat_e) = self.staggered, self.slopes_of_pressure, self.slopes_of_heat
        outflow = sparse.hstack(grid.stretch)
        mean, slope = sparse.vstack(grid.mean), sparse.vstack(grid.slope)
        braking = self.stress @ diagonal(1.0 / (mean @ self.n)) - self.friction * sparse.eye_array(mean.shape[0])
        return sparse.block_array(
            [
                [None, None, -outflow],
                [heat_n, heat_e, -outflow @ diagonal(mean @ self.enthalpy)],
                [-slope @ diagonal(p_n), -slope @ diagonal(p_e), braking],
            ],
            format="csr",
        )

    def resolvent(self, shift: complex) -> Callable[[np.ndarray], np.ndarray]:
        return splu((self.matrix - shift * sparse.eye_array(self.matrix.shape[0])).tocsc()).solve

    def relevant(self, y: np.ndarray) -> np.ndarray:
        """y without the mean of n'; as it is where mass may cross the mirror."""
        return np.concatenate([self.without_mean(y[: self.n.size]), y[self.n.size :]])

    def momentum(self, flow: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        back_x, back_y = self.staggered.back
        momentum_x, momentum_y = np.split(flow, [back_x.shape[1]])
        return (back_x @ momentum_x).reshape(self.state.mesh.cells), (back_y @ momentum_y).reshape(
            self.state.mesh.cells
        )
