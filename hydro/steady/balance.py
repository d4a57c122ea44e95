"""The steady equations on a mesh: heat conducted into every cell is lost there by collisions, at uniform pressure.

Pressure sets only the scale of the temperature: with T = p theta(n), conduction and cooling are both proportional to
p^(3/2). So temperatures are measured here in units in which p = 1; the pressure itself enters by the wall alone,
by its strength over p or by T_wall/p, and follows from the mass in the box. The unknowns are w = log(1/n - 1/n_p) in
every cell, which keeps n between 0 and the density n_p of packing by itself, and the logarithm of p.

Fluxes, cooling and the law of the wall are those of the evolution code, so that its steady states are these.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from hydro.choices import PARAMETERS
from hydro.gas import Closure
from hydro.gas.packing import density_at, gap_at
from hydro.mesh import Mesh
from hydro.state import State
from hydro.steady.operators import Faces, diagonal
from hydro.steady.problem import NotConverged, Slopes
from hydro.walls.boundary import wall_heat

LOWEST = -30.0  # of w: closer to packing n is a number too coarse to work with
PACKED = 1e-9  # e^w below which the cells of a branch cannot tell densities apart


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
        n = density_at(gas, w)
        n_w = -n * gap_at(gas, w)
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
        """The vector u for w, (nx, ny), and p."""
        return np.append(np.broadcast_to(log_void, self.mesh.cells), np.log(pressure))

    def residual(self, u: np.ndarray) -> np.ndarray:
        """Net heating of every cell, and excess of mass, (cells + 1,)."""
        here = Local.of(self.gas, u[:-1])
        heating = self.faces.diffused(here.kappa, here.T) - self.areas * here.cooling
        flux, _ = self._wall_heat(here, u[-1])
        heating[self.last] += flux * self.mesh.dy
        return np.append(heating, self.areas @ here.n - self.area_fraction * self.mesh.aspect_ratio)

    def slopes(self, u: np.ndarray) -> Slopes:
        """Derivatives of the residual: of heating in w, (cells, cells), and in log p, and of mass in w."""
        here = Local.of(self.gas, u[:-1])
        conducted = self.faces.drift(here.T) @ diagonal(here.kappa_w) + self.faces.diffusion(here.kappa) @ diagonal(
            here.T_w
        )
        in_w, in_p = self._wall_slopes(here, u[-1])
        lost = self.areas * here.cooling_w
        lost[self.last] -= in_w * self.mesh.dy
        in_log_p = np.zeros_like(lost)
        in_log_p[self.last] = in_p * self.mesh.dy
        matrix, mass = (conducted - diagonal(lost)).tocsc(), self.areas * here.n_w
        return Slopes(matrix, in_log_p[:, None], mass[None, :], np.zeros((1, 1)))

    def scale(self, u: np.ndarray) -> np.ndarray:
        """What the residuals are small against: collisions in all cells, and the mass; (cells + 1,)."""
        here = Local.of(self.gas, u[:-1])
        turnover = self.areas @ here.cooling / self.areas.size
        return np.append(np.full(here.n.size, turnover), self.area_fraction * self.mesh.aspect_ratio)

    def round_off(self, u: np.ndarray) -> np.ndarray:
        """What residuals cannot fall below: the temperature is known to the last digit of the gap; (cells + 1,)."""
        here = Local.of(self.gas, u[:-1])
        last_digit = 4.0 * np.finfo(float).eps
        fluxes = self.faces.absolute(here.kappa, last_digit * here.T / self.gas.gap(here.n))
        return np.append(fluxes + last_digit * self.areas * here.cooling, last_digit * self.areas @ here.n)

    def capacity(self, u: np.ndarray) -> np.ndarray:
        """Mass that a cell loses as w rises, in units in which a mean gas cools once in unit time; (cells,)."""
        n_w = Local.of(self.gas, u[:-1]).n_w
        return self.scale(u)[0] / self.areas.mean() * (-(self.areas * n_w)) / self.area_fraction

    def refuse(self, u: np.ndarray) -> None:
        """NotConverged where the gap falls below what the cells can tell apart."""
        lowest = int(np.argmin(u[:-1]))
        if u[lowest] < LOWEST:
            i, j = np.unravel_index(lowest, self.mesh.cells)
            raise NotConverged(
                f"no steady state found on {self.place}: the gas packs, its gap 1 - n/n_p falls below "
                f"{np.exp(LOWEST):.0e} at x = {self.mesh.x[i]:.3g}, y = {self.mesh.y[j]:.3g}; "
                "smaller f or L avoid that"
            )

    @property
    def place(self) -> str:
        """The cells in words."""
        return f"{self.mesh.cells[0]} x {self.mesh.cells[1]} cells"

    def parameters(self) -> tuple[str, ...]:
        """Area fraction, aspect ratio, and what the closure offers."""
        return (*PARAMETERS, *self.gas.parameters())

    def with_parameter(self, name: str, value: float) -> Balance:
        """The problem for another value of one of its parameters."""
        if name in PARAMETERS:
            return PARAMETERS[name](self, value)
        return replace(self, gas=self.gas.with_parameter(name, value))

    @cached_property
    def weights(self) -> np.ndarray:
        """Shares of the cells in the box, and none for the pressure; (cells + 1,)."""
        return np.append(self.areas / self.areas.sum(), 0.0)

    def amplitude(self, u: np.ndarray) -> float:
        """How much denser the row x = 0 is at y = 0 than at the other end: minus the cosine component of w there."""
        w = u[:-1].reshape(self.mesh.cells)[0]
        return float(-2.0 * np.mean(w * np.cos(np.pi * (np.arange(w.size) + 0.5) / w.size)))

    def obstacle(self, u: np.ndarray) -> str:
        """Close packing."""
        return "reaches close packing" if np.min(u[:-1]) < math.log(PACKED) else ""

    def density(self, u: np.ndarray) -> np.ndarray:
        """n, (nx, ny)."""
        return density_at(self.gas, u[:-1]).reshape(self.mesh.cells)

    def state(self, u: np.ndarray) -> State:
        """The steady state as a state of the evolution code, at rest."""
        n, p = self.density(u), np.exp(u[-1])
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


def with_area_fraction(balance: Balance, value: float) -> Balance:
    """The problem with another area fraction."""
    return replace(balance, area_fraction=value)


def with_aspect_ratio(balance: Balance, value: float) -> Balance:
    """The problem in a box of another width; `value` is the aspect ratio of the balance's own mesh."""
    mesh = balance.mesh
    return balance.on(Mesh(mesh.x_faces, mesh.y_faces * (value / mesh.aspect_ratio)))
