"""Growth rates: eigenvalues of the time-dependent equations, linearized about a steady state.

The state is at rest. Without viscosity momentum obeys d(n v)/dt = -grad p' - n v/tau: what is not a gradient decays
like exp(-t/tau), whatever the rest does (a family of shear modes with the same eigenvalue -1/tau, which density and
temperature follow because they carry enthalpy about); the rest has a potential, n v = -grad psi. That leaves three
equations,

    dn'/dt   = div grad psi
    de'/dt   = div(h grad psi) + (div(kappa grad T) - I)',      h = (e + p)/n
    dpsi/dt  = p' - psi/tau,

without shear modes by construction. They are discretized on the finite volumes of the heat operator. An eigenvalue
zero belongs to the neighbouring steady state of a little more mass; perturbations without net mass, an invariant space,
leave it out. So is a constant potential, which moves nothing (and decays like exp(-t/tau)). A viscous gas keeps its
velocities as unknowns: `hydro.steady.viscous`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import ArpackError, LinearOperator, eigs

from hydro.errors import RunFailed
from hydro.state import State
from hydro.steady.linear import factorized
from hydro.steady.operators import Faces, diagonal
from hydro.steady.rightmost import Disc, rightmost, sharpened
from hydro.steady.staggered import Between, Staggered
from hydro.walls.boundary import wall_heat

FUNDAMENTAL = np.pi  # wave number of sound, in 1/L_x, up to whose frequency oscillations are looked for, at least
BASIS = 4  # vectors of the iteration over modes that it is asked for
TOLERANCE = 1e-11  # of the iteration, relative to the distance from the shift
MODES = 3  # leading ones that are looked for
IRRELEVANT = 1e-6  # share of a mode outside what is relevant, from which it is none


@dataclass(frozen=True, eq=False)
class Sector:
    """Perturbations of one symmetry.

    leak: (nx, ny), what a unit coefficient and a unit perturbation lose across faces where the perturbation is odd, or
    by its variation in y if the mesh has a single cell there. between: the places in y where v does not vanish.
    wave_number: in y, if the mesh has a single cell there.
    """

    name: str
    leak: np.ndarray
    between: Between
    wave_number: float = 0.0


def even(mesh) -> Sector:
    """Perturbations that are even about all walls, or mirrors."""
    return Sector("symmetric", np.zeros(mesh.cells), Between.cells(mesh.dy))


def odd(mesh, sides: tuple[int, ...] = (-1,)) -> Sector:
    """Perturbations that are odd about the upper side in y, a mirror of the state; (0, -1): about both sides."""
    leak = np.zeros(mesh.cells)
    for side in sides:
        leak[:, side] = 2.0 * mesh.dx / mesh.dy[side]
    return Sector("antisymmetric", leak, Between.cells(mesh.dy, sides))


def wave_sector(mesh, cells: int, aspect_ratio: float, wave: int) -> Sector:
    """Perturbations ~ cos(pi wave y/aspect_ratio) of a state uniform in y, as on a mesh of `cells` cells in y.

    The mesh itself has one cell in y. Nothing flows along y for wave = 0.
    """
    width = aspect_ratio / cells
    turn = 0.5 * np.pi * wave / cells  # of the phase, over half a cell
    slope = 2.0 / width * np.sin(turn)
    between = Between.wave(mesh.dy, slope, np.cos(turn)) if wave else Between.cells(mesh.dy)
    return Sector(f"{wave} half-wave{'' if wave == 1 else 's'}", slope**2 * mesh.areas, between, slope)


@dataclass(frozen=True, eq=False)
class Mode:
    """An eigenmode: growth rate per unit time (complex if it oscillates), and fields (nx, ny).

    density, temperature: perturbations; momentum_x, momentum_y: densities of momentum.
    """

    growth_rate: complex
    sector: str
    density: np.ndarray
    temperature: np.ndarray
    momentum_x: np.ndarray
    momentum_y: np.ndarray


class Linearized(ABC):
    """The equations linearized about a steady state, in one sector: y' = matrix y for y = (n', e', what flows).

    tau: friction time. Density and energy are per area, in cells; what flows is up to the derived class.
    """

    def __init__(self, state: State, wall: Any, tau: float, sector: Sector):
        self.state, self.friction, self.sector = state, 1.0 / tau, sector
        gas, mesh = state.gas, state.mesh
        self._faces = Faces(mesh)
        self.areas = mesh.areas.ravel()
        n, T = state.density.ravel(), state.temperature.ravel()
        self.p_n, self.p_T = gas.pressure_slopes(n, T)
        self.n_p, self.n_T = gas.density_slopes(n, T)
        self.e_p, self.e_T = T * self.n_p, T * self.n_T + n
        self.n, self.T = n, T
        self.enthalpy = T + gas.pressure(n, T) / n
        self.heat_p, self.heat_T = self._heat_slopes(wall)

    @property
    @abstractmethod
    def matrix(self) -> sparse.csr_array:
        """The whole linear system."""

    @abstractmethod
    def resolvent(self, shift: complex) -> Callable[[np.ndarray], np.ndarray]:
        """A function that solves (matrix - shift) y = r."""

    @abstractmethod
    def relevant(self, y: np.ndarray) -> np.ndarray:
        """y without what belongs to another state, or moves nothing."""

    @abstractmethod
    def momentum(self, flow: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Momentum in cells, (nx, ny) each, of the part of y that flows."""

    @cached_property
    def staggered(self) -> Staggered:
        """Slopes and means between cells."""
        return Staggered(Between.cells(self.state.mesh.dx), self.sector.between)

    @property
    def slopes_of_pressure(self) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of p' in n' and e'; (cells,)."""
        return self.p_n - self.p_T * self.T / self.n, self.p_T / self.n

    @property
    def slopes_of_heat(self) -> tuple[sparse.csr_array, sparse.csr_array]:
        """Derivatives of the heating per area of cells in n' and e'; (cells, cells)."""
        over, (p_n, p_e) = diagonal(1.0 / self.areas), self.slopes_of_pressure
        in_n = self.heat_p @ diagonal(p_n) + self.heat_T @ diagonal(-self.T / self.n)
        in_e = self.heat_p @ diagonal(p_e) + self.heat_T @ diagonal(1.0 / self.n)
        return over @ in_n, over @ in_e

    def leading(self, count: int = MODES, hints: list[complex] | None = None) -> list[Mode]:
        """The `count` modes of largest growth rate, that of the largest first; a pair that oscillates counts as one.

        hints: growth rates of those that oscillate, roughly, if they are known. RunFailed if no modes are found.
        """
        if hints is None:
            found = rightmost(self.around, self.default_shift, count, self.sound)
        else:
            found = sharpened(self.around, self.default_shift, count, hints)
        return [self._mode(value, vector) for value, vector in found]

    def around(self, shift: complex) -> Callable[[int], Disc]:
        """A function that gives all modes in a disc around a shift, so large that it has about so many of them."""
        shift = shift if shift.imag else float(shift.real)
        solve = cache(lambda: self.resolvent(shift))

        def nearest(count: int) -> Disc:
            if count > self.matrix.shape[0] // 3:
                return Disc.of(shift, *self._all(), whole=True)
            return Disc.of(shift, *self._nearest(solve(), shift, count), whole=False)

        return nearest

    def _nearest(self, solve: Callable, shift: complex, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Values and vectors of the modes nearest to a shift."""
        size, kind = self.matrix.shape[0], complex if isinstance(shift, complex) else float
        operator = LinearOperator((size, size), matvec=lambda y: self.relevant(solve(y)), dtype=kind)
        start = self.relevant(np.random.default_rng(1).standard_normal(size).astype(kind))
        zeros = sparse.csr_array((size, size), dtype=kind)  # for its shape only
        try:
            return eigs(
                zeros, k=count, sigma=shift, OPinv=operator, v0=start, ncv=min(BASIS * count, size), tol=TOLERANCE
            )
        except ArpackError as error:
            raise RunFailed(f"no growth rates found, {self.sector.name} perturbations: {error}") from None

    def _all(self) -> tuple[np.ndarray, np.ndarray]:
        """Values and vectors of all modes."""
        matrix = np.array([self.relevant(column) for column in self.matrix.toarray().T]).T
        values, vectors = np.linalg.eig(matrix)
        rests = [np.linalg.norm(self.relevant(vector) - vector) for vector in vectors.T]
        there = np.array(rests) < IRRELEVANT
        return values[there], vectors[:, there]

    @property
    def sound(self) -> float:
        """The frequency of sound of half a wavelength across the box, where it is fastest."""
        fastest = float(self.state.sound_speed.max())
        return fastest * float(np.hypot(FUNDAMENTAL, self.sector.wave_number))

    @property
    def default_shift(self) -> float:
        """A rate of the order of slow growth: a small share of the collisional cooling rate of the whole gas."""
        cooling = self.areas @ self.state.gas.cooling(self.n, self.T)
        return 0.02 * float(cooling / (self.areas @ (self.n * self.T)))

    def without_mean(self, n: np.ndarray) -> np.ndarray:
        """A field less its mean; as it is where mass may cross the mirror."""
        return n if self.sector.leak.any() else n - self.areas @ n / self.areas.sum()

    def _mode(self, value: complex, vector: np.ndarray) -> Mode:
        count = self.n.size
        n = vector[:count]
        phase = n[np.argmax(np.abs(n))]
        vector = vector / (phase / abs(phase) if abs(phase) > 0.0 else 1.0)
        vector = vector if value.imag else vector.real
        n, e, flow = vector[:count], vector[count : 2 * count], vector[2 * count :]
        density, temperature = (field.reshape(self.state.mesh.cells) for field in (n, (e - self.T * n) / self.n))
        momentum_x, momentum_y = self.momentum(flow)
        return Mode(value, self.sector.name, density, temperature, momentum_x, momentum_y)

    def _diffusion(self, coefficient: np.ndarray) -> sparse.csr_array:
        """div(coefficient grad), integrated over cells, for perturbations of the sector."""
        return self._faces.diffusion(coefficient) - diagonal(self.sector.leak.ravel() * coefficient)

    def _heat_slopes(self, wall: Any) -> tuple[sparse.csr_array, sparse.csr_array]:
        """Derivatives of the net heating of cells in p and in T, matrices (cells, cells)."""
        gas, mesh = self.state.gas, self.state.mesh
        last = np.arange(self.areas.size).reshape(mesh.cells)[-1]
        half_width = 0.5 * mesh.dx[-1]
        (k_n, k_T), (i_n, i_T) = gas.conductivity_slopes(self.n, self.T), gas.cooling_slopes(self.n, self.T)
        _, face = wall_heat(gas, wall, self.n[last], self.T[last], half_width)
        f_n, f_T = wall.face_slopes(gas, self.n[last], self.T[last], half_width, face)
        drift = self._faces.drift(self.T)
        local_p, local_T = -self.areas * i_n * self.n_p, -self.areas * (i_n * self.n_T + i_T)
        local_p[last] += mesh.dy * f_n * self.n_p[last]
        local_T[last] += mesh.dy * (f_n * self.n_T[last] + f_T)
        in_p = drift @ diagonal(k_n * self.n_p) + diagonal(local_p)
        in_T = drift @ diagonal(k_n * self.n_T + k_T) + diagonal(local_T)
        return in_p, in_T + self._diffusion(gas.conductivity(self.n, self.T))


class Linearization(Linearized):
    """Of a gas without viscosity: what flows is psi, with n v = -grad psi; (3 cells, 3 cells)."""

    @cached_property
    def motion(self) -> sparse.csr_array:
        """div grad."""
        return self._diffusion(np.ones_like(self.n))

    @cached_property
    def enthalpy_motion(self) -> sparse.csr_array:
        """div(h grad)."""
        return self._diffusion(self.enthalpy)

    @cached_property
    def matrix(self) -> sparse.csr_array:
        over, (p_n, p_e), (heat_n, heat_e) = diagonal(1.0 / self.areas), self.slopes_of_pressure, self.slopes_of_heat
        one = sparse.eye_array(self.n.size)
        return sparse.block_array(
            [
                [None, None, over @ self.motion],
                [heat_n, heat_e, over @ self.enthalpy_motion],
                [diagonal(p_n), diagonal(p_e), -self.friction * one],
            ],
            format="csr",
        )

    def resolvent(self, shift: complex):
        """A function that solves (matrix - shift) y = r, by elimination of everything but p' and T'."""
        rate = shift + self.friction
        inertia = shift * rate * self.areas
        reduced = sparse.block_array(
            [
                [self.motion - diagonal(inertia * self.n_p), diagonal(-inertia * self.n_T)],
                [
                    self.enthalpy_motion + rate * self.heat_p - diagonal(inertia * self.e_p),
                    rate * self.heat_T - diagonal(inertia * self.e_T),
                ],
            ],
            format="csc",
        )
        factors = factorized(interleaved(reduced))

        def solve(right: np.ndarray) -> np.ndarray:
            r_n, r_e, r_psi = np.split(right, 3)
            top = rate * self.areas * r_n + self.motion @ r_psi
            bottom = rate * self.areas * r_e + self.enthalpy_motion @ r_psi
            p, T = factors.solve(np.stack([top, bottom], axis=1).ravel()).reshape(-1, 2).T
            return np.concatenate([self.n_p * p + self.n_T * T, self.e_p * p + self.e_T * T, (p - r_psi) / rate])

        return solve

    def relevant(self, y: np.ndarray) -> np.ndarray:
        """(n', e', psi) without the means of n' and psi; as it is where mass may cross the mirror."""
        n, e, psi = np.split(y, 3)
        return np.concatenate([self.without_mean(n), e, self.without_mean(psi)])

    def momentum(self, flow: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        pairs = zip(self.staggered.back, self.staggered.slope, strict=True)
        momentum_x, momentum_y = (-(back @ (slope @ flow)).reshape(self.state.mesh.cells) for back, slope in pairs)
        return momentum_x, momentum_y


def interleaved(matrix: sparse.csc_array) -> sparse.csc_array:
    """A matrix of 2 x 2 blocks with the two unknowns of each cell next to each other: less fill in its factors."""
    cells = matrix.shape[0] // 2
    order = np.arange(2 * cells).reshape(2, cells).T.ravel()
    return matrix[order][:, order].tocsc()
