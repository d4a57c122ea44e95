"""The steady equations on a mesh: heat conducted into every cell is lost there by collisions, at uniform pressure.

Pressure sets only the scale of the temperature: with T = p theta(n), conduction and cooling are both proportional to
p^(3/2). So temperatures are measured here in units in which p = 1; the pressure itself enters by the wall alone,
as W/p or T_wall/p, and follows from the mass in the box. The unknowns are w = log(1/n - 1) in every cell, which keeps
n in (0, 1) by itself, and the logarithm of p.

Fluxes, cooling and the law of the wall are those of the evolution code, so that its steady states are these.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy import sparse
from scipy.special import expit

from hydro.gas import Closure
from hydro.mesh import Mesh
from hydro.state import State
from hydro.steady.operators import Faces, diagonal
from hydro.walls.boundary import wall_heat


@dataclass(frozen=True, eq=False)
class Local:
    """What the closure says of every cell at p = 1, with slopes in w; all (cells,)."""

    n: np.ndarray
    n_w: np.ndarray
    T: np.ndarray
    T_w: np.ndarray
    kappa: np.ndarray
    kappa_w: np.ndarray
    cooling: np.ndarray
    cooling_w: np.ndarray

    @classmethod
    def of(cls, gas: Closure, w: np.ndarray) -> Local:
        n = expit(-w)
        n_w = -n * expit(w)
        T = gas.temperature(n, 1.0)
        p_n, p_T = gas.pressure_slopes(n, T)
        T_w = -p_n / p_T * n_w
        (k_n, k_T), (i_n, i_T) = gas.conductivity_slopes(n, T), gas.cooling_slopes(n, T)
        return cls(
            n, n_w, T, T_w,
            gas.conductivity(n, T), k_n * n_w + k_T * T_w,
            gas.cooling(n, T), i_n * n_w + i_T * T_w,
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Balance:
    """The steady problem of a gas in a box: area fraction, mesh and driving wall are given.

    The unknowns stand in one vector u of shape (cells + 1,): w of every cell, then log p. So do the residuals: the net
    heating of every cell (energy per time, at p = 1), then the mass in the box less the mass it should hold.
    """

    gas: Closure
    wall: Any
    faces: Faces
    area_fraction: float

    @classmethod
    def of(cls, gas: Closure, wall: Any, mesh: Mesh, area_fraction: float) -> Balance:
        """The problem on a mesh."""
        return cls(gas, wall, Faces(mesh), area_fraction)

    def on(self, mesh: Mesh) -> Balance:
        """The same problem on another mesh."""
        return replace(self, faces=Faces(mesh))

    @property
    def mesh(self) -> Mesh:
        """Where the cells are."""
        return self.faces.mesh

    @cached_property
    def areas(self) -> np.ndarray:
        """Cell areas, (cells,)."""
        return self.mesh.areas.ravel()

    @cached_property
    def last(self) -> np.ndarray:
        """Numbers of the cells at the driving wall, (ny,)."""
        return np.arange(self.areas.size).reshape(self.mesh.cells)[-1]

    def unknowns(self, log_void: np.ndarray, pressure: float) -> np.ndarray:
        """The vector u for w = log(1/n - 1), (nx, ny), and p."""
        return np.append(np.broadcast_to(log_void, self.mesh.cells), np.log(pressure))

    def residual(self, u: np.ndarray) -> np.ndarray:
        """Net heating of every cell, and excess of mass, (cells + 1,)."""
        here = Local.of(self.gas, u[:-1])
        heating = self.faces.diffused(here.kappa, here.T) - self.areas * here.cooling
        flux, _ = self._wall_heat(here, u[-1])
        heating[self.last] += flux * self.mesh.dy
        return np.append(heating, self.areas @ here.n - self.area_fraction * self.mesh.aspect_ratio)

    def slopes(self, u: np.ndarray) -> tuple[sparse.csc_array, np.ndarray, np.ndarray]:
        """Derivatives of the residual: of heating in w (cells, cells), of heating in log p, of mass in w; (cells,)."""
        here = Local.of(self.gas, u[:-1])
        conducted = self.faces.drift(here.T) @ diagonal(here.kappa_w) + self.faces.diffusion(here.kappa) @ diagonal(
            here.T_w
        )
        in_w, in_p = self._wall_slopes(here, u[-1])
        lost = self.areas * here.cooling_w
        lost[self.last] -= in_w * self.mesh.dy
        in_log_p = np.zeros_like(lost)
        in_log_p[self.last] = in_p * self.mesh.dy
        return (conducted - diagonal(lost)).tocsc(), in_log_p, self.areas * here.n_w

    def scale(self, u: np.ndarray) -> np.ndarray:
        """What the residuals are small against: collisions in all cells, and the mass; (cells + 1,)."""
        here = Local.of(self.gas, u[:-1])
        turnover = self.areas @ here.cooling / self.areas.size
        return np.append(np.full(here.n.size, turnover), self.area_fraction * self.mesh.aspect_ratio)

    def round_off(self, u: np.ndarray) -> np.ndarray:
        """What residuals cannot fall below: the temperature is known to the last digit of 1-n; (cells + 1,)."""
        here = Local.of(self.gas, u[:-1])
        last_digit = 4.0 * np.finfo(float).eps
        fluxes = self.faces.absolute(here.kappa, last_digit * here.T / (1.0 - here.n))
        return np.append(fluxes + last_digit * self.areas * here.cooling, last_digit * self.areas @ here.n)

    def state(self, u: np.ndarray) -> State:
        """The steady state as a state of the evolution code, at rest."""
        n, p = expit(-u[:-1]).reshape(self.mesh.cells), np.exp(u[-1])
        return State.of(self.gas, self.mesh, n, self.gas.temperature(n, p))

    def _wall_heat(self, here: Local, log_p: float) -> tuple[np.ndarray, np.ndarray]:
        """Heat flux from the wall, at p = 1, and the temperature of the wall; (ny,)."""
        p = np.exp(log_p)
        flux, face = wall_heat(self.gas, self.wall, here.n[self.last], p * here.T[self.last], 0.5 * self.mesh.dx[-1])
        return flux / p**1.5, face

    def _wall_slopes(self, here: Local, log_p: float) -> tuple[np.ndarray, np.ndarray]:
        """Slopes of the wall's heat flux, at p = 1, in w of the last cells and in log p; (ny,)."""
        last, p = self.last, np.exp(log_p)
        flux, face = self._wall_heat(here, log_p)
        in_n, in_T = self.wall.face_slopes(self.gas, here.n[last], p * here.T[last], 0.5 * self.mesh.dx[-1], face)
        in_n, in_T = in_n / p**1.5, in_T / p**0.5
        return in_n * here.n_w[last] + in_T * here.T_w[last], in_T * here.T[last] - 1.5 * flux
