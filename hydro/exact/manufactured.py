"""A solution made up beforehand, and the source that makes it one: every term of the equations at once.

Pressure, temperature and velocity are chosen as smooth functions of x, y and t that satisfy the conditions at the
walls, that of the vibrating wall included. Put into the equations, with conduction, cooling and friction, they leave a
remainder; given to an integrator as a source, it makes them the solution. Derivatives are complex-step derivatives,
exact to round-off; averages over cells are taken with four Gauss points.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from hydro.mesh import Mesh
from hydro.terms import Friction, Source, Term, Viscosity

STEP = 1e-30  # of the complex-step derivatives
OFFSETS = (-0.5 / 3.0**0.5, 0.5 / 3.0**0.5)  # of the two Gauss points, in cell widths


class Fields(NamedTuple):
    """Primitive variables, the temperature gradient and the rates of strain."""

    n: Any
    u: Any
    v: Any
    p: Any
    T: Any
    T_x: Any
    T_y: Any
    u_x: Any
    v_y: Any
    shear_rate: Any  # u_y + v_x


@dataclass(frozen=True)
class Manufactured:
    """The made-up solution in a box with elastic walls and, at x = 1, a vibrating one (strength 0: elastic too).

    gas: a closure with its constants; tau: friction time; viscosity: over that of the closure. 0.35 < p < 0.65 and T
    is about 1, so n is about 0.3.
    """

    gas: Any
    tau: float = math.inf
    strength: float = 0.0
    aspect_ratio: float = 1.0
    viscosity: float = 0.0

    def fields(self, x, y, t) -> Fields:
        """The solution at points x, y, arrays that broadcast.

        Normal velocities, and normal slopes of p and of the velocity along the wall, vanish at all walls; so do those
        of T but at x = 1, where kappa T_x = strength n T^(1/2).
        """
        gas, kx, ky = self.gas, np.pi, np.pi / self.aspect_ratio
        beat, swing = np.cos(2.0 * t), np.sin(1.0 + 3.0 * t)
        u = 0.4 * np.sin(kx * x) * np.cos(2.0 * ky * y) * swing
        v = 0.3 * np.cos(kx * x) * np.sin(ky * y) * beat
        u_x = 0.4 * kx * np.cos(kx * x) * np.cos(2.0 * ky * y) * swing
        v_y = 0.3 * ky * np.cos(kx * x) * np.cos(ky * y) * beat
        u_y = -0.8 * ky * np.sin(kx * x) * np.sin(2.0 * ky * y) * swing
        v_x = -0.3 * kx * np.sin(kx * x) * np.sin(ky * y) * beat
        p = 0.5 + 0.15 * np.cos(kx * x) * np.cos(ky * y) * beat
        wave = 0.2 * np.cos(2.0 * ky * y) * swing
        slope, slope_y = self._wall_slope(y, beat, swing)
        T = 1.0 + np.cos(kx * x) * wave + slope * x * x * (x - 1.0)
        T_x = -kx * np.sin(kx * x) * wave + slope * x * (3.0 * x - 2.0)
        T_y = -0.4 * ky * np.cos(kx * x) * np.sin(2.0 * ky * y) * swing + slope_y * x * x * (x - 1.0)
        return Fields(gas.density(p, T), u, v, p, T, T_x, T_y, u_x, v_y, u_y + v_x)

    def _wall_slope(self, y, beat, swing):
        """T_x at the vibrating wall, strength n/k with kappa = k T^(1/2), and its slope in y."""
        gas, ky = self.gas, np.pi / self.aspect_ratio
        if self.strength == 0.0:
            return 0.0, 0.0
        p, p_y = 0.5 - 0.15 * np.cos(ky * y) * beat, 0.15 * ky * np.sin(ky * y) * beat
        T, T_y = 1.0 - 0.2 * np.cos(2.0 * ky * y) * swing, 0.4 * ky * np.sin(2.0 * ky * y) * swing
        n = gas.density(p, T)
        n_p, n_T = gas.density_slopes(n, T)
        k, k_n = gas.conductivity_coefficient(n), gas.conductivity_coefficient_slope(n)
        return self.strength * n / k, self.strength * (k - n * k_n) / k**2 * (n_p * p_y + n_T * T_y)

    def conserved(self, mesh: Mesh, t: float) -> np.ndarray:
        """Cell averages of density, momenta and energy, shape (4, nx, ny)."""
        return averaged(self._conserved, mesh, t)

    @property
    def terms(self) -> list[Term]:
        """The terms of the equations that it solves."""
        return [Friction(self.tau), Viscosity(self.viscosity), Source(self.source)]

    def source(self, t: float, mesh: Mesh) -> np.ndarray:
        """What is to be added to the equations: cell averages, shape (4, nx, ny)."""
        return averaged(self._remainder, mesh, t)

    def _conserved(self, x, y, t) -> np.ndarray:
        n, u, v, _, T, *_ = self.fields(x, y, t)
        return np.stack(np.broadcast_arrays(n, n * u, n * v, n * T + 0.5 * n * (u * u + v * v)))

    def _fluxes(self, x, y, t, axis: int) -> np.ndarray:
        """Fluxes along `axis` of the conserved fields, heat conduction and viscous stress included."""
        field = self.fields(x, y, t)
        across, gradient, stretched = ((field.u, field.T_x, field.u_x), (field.v, field.T_y, field.v_y))[axis]
        mass = field.n * across
        push = (field.p, 0.0) if axis == 0 else (0.0, field.p)
        energy = field.n * (field.T + 0.5 * (field.u**2 + field.v**2)) + field.p
        heat = self.gas.conductivity(field.n, field.T) * gradient
        eta, zeta = (self.viscosity * part for part in self.gas.viscosities(field.n, field.T))
        normal, shear = 2.0 * eta * stretched + (zeta - eta) * (field.u_x + field.v_y), eta * field.shear_rate
        along_x, along_y = (normal, shear) if axis == 0 else (shear, normal)
        work = along_x * field.u + along_y * field.v
        momenta = (mass * field.u + push[0] - along_x, mass * field.v + push[1] - along_y)
        parts = (mass, *momenta, energy * across - heat - work)
        return np.stack(np.broadcast_arrays(*parts))

    def _remainder(self, x, y, t) -> np.ndarray:
        """d/dt of the conserved fields + divergence of their fluxes + friction and cooling."""
        by_step = (
            self._conserved(x, y, t + 1j * STEP),
            self._fluxes(x + 1j * STEP, y, t, 0),
            self._fluxes(x, y + 1j * STEP, t, 1),
        )
        field, rate = self.fields(x, y, t), 1.0 / self.tau
        lost = self.gas.cooling(field.n, field.T) + rate * field.n * (field.u**2 + field.v**2)
        rubbed = (0.0 * field.n, rate * field.n * field.u, rate * field.n * field.v, lost)
        return sum(part.imag for part in by_step) / STEP + np.stack(np.broadcast_arrays(*rubbed))


def averaged(function: Callable, mesh: Mesh, t: float) -> np.ndarray:
    """Cell averages of function(x, y, t), which gives (4, nx, ny), by four Gauss points."""
    points = itertools.product(OFFSETS, repeat=2)
    return sum(0.25 * function((mesh.x + a * mesh.dx)[:, None], (mesh.y + b * mesh.dy)[None, :], t) for a, b in points)
