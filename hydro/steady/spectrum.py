"""Growth rates: eigenvalues of the time-dependent equations, linearized about a steady state.

The state is at rest, so momentum obeys d(n v)/dt = -grad p' - n v/tau: what is not a gradient decays like
exp(-t/tau), whatever the rest does (a family of shear modes with the same eigenvalue -1/tau, which density and
temperature follow because they carry enthalpy about); the rest has a potential, n v = -grad psi. That leaves three
equations,

    dn'/dt   = div grad psi
    de'/dt   = div(h grad psi) + (div(kappa grad T) - I)',      h = (e + p)/n
    dpsi/dt  = p' - psi/tau,

without shear modes by construction. They are discretized on the finite volumes of the heat operator. An eigenvalue
zero belongs to the neighbouring steady state of a little more mass; perturbations without net mass, an invariant space,
leave it out. So is a constant potential, which moves nothing (and decays like exp(-t/tau)).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import ArpackError, LinearOperator, eigs

from hydro.errors import RunFailed
from hydro.state import State
from hydro.steady.linear import factorized
from hydro.steady.operators import Faces, diagonal
from hydro.walls.boundary import wall_heat

NEAREST = 6  # eigenvalues looked at, around the shift


@dataclass(frozen=True, eq=False)
class Sector:
    """Perturbations of one symmetry.

    leak: (nx, ny), what a unit coefficient and a unit perturbation lose across faces where the perturbation is odd, or
    by its variation in y if the mesh has a single cell there.
    """

    name: str
    leak: np.ndarray


def even(mesh) -> Sector:
    """Perturbations that are even about all walls, or mirrors."""
    return Sector("symmetric", np.zeros(mesh.cells))


def odd(mesh, sides: tuple[int, ...] = (-1,)) -> Sector:
    """Perturbations that are odd about the upper side in y, a mirror of the state; (0, -1): about both sides."""
    leak = np.zeros(mesh.cells)
    for side in sides:
        leak[:, side] = 2.0 * mesh.dx / mesh.dy[side]
    return Sector("antisymmetric", leak)


def wave_sector(mesh, cells: int, aspect_ratio: float, wave: int) -> Sector:
    """Perturbations ~ cos(pi wave y/aspect_ratio) of a state uniform in y, as on a mesh of `cells` cells in y.

    The mesh itself has one cell in y.
    """
    width = aspect_ratio / cells
    rate = (2.0 / width * np.sin(0.5 * np.pi * wave / cells)) ** 2
    return Sector(f"{wave} half-wave{'' if wave == 1 else 's'}", rate * mesh.areas)


@dataclass(frozen=True, eq=False)
class Mode:
    """An eigenmode: growth rate per unit time (complex if it oscillates), and fields (nx, ny).

    density, temperature: perturbations; potential: psi, with n v = -grad psi.
    """

    growth_rate: complex
    sector: str
    density: np.ndarray
    temperature: np.ndarray
    potential: np.ndarray


class Linearization:
    """The equations linearized about a steady state, in one sector. tau: friction time."""

    def __init__(self, state: State, wall: Any, tau: float, sector: Sector, faces: Faces | None = None):
        self.state, self.friction, self.sector = state, 1.0 / tau, sector
        gas, mesh = state.gas, state.mesh
        self._faces = faces or Faces(mesh)
        self.areas = mesh.areas.ravel()
        n, T = state.density.ravel(), state.temperature.ravel()
        self.p_n, self.p_T = gas.pressure_slopes(n, T)
        self.n_p, self.n_T = gas.density_slopes(n, T)
        self.e_p, self.e_T = T * self.n_p, T * self.n_T + n
        self.n, self.T = n, T
        self.motion = self._diffusion(np.ones_like(n))
        self.enthalpy_motion = self._diffusion(T + gas.pressure(n, T) / n)
        self.heat_p, self.heat_T = self._heat_slopes(wall)

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

    @cached_property
    def matrix(self) -> sparse.csr_array:
        """The whole linear system, y' = matrix y for y = (n', e', psi); (3 cells, 3 cells)."""
        over = diagonal(1.0 / self.areas)
        # p' and T' from n' and e'
        T_n, T_e = -self.T / self.n, 1.0 / self.n
        p_n, p_e = self.p_n + self.p_T * T_n, self.p_T * T_e
        heat_n = self.heat_p @ diagonal(p_n) + self.heat_T @ diagonal(T_n)
        heat_e = self.heat_p @ diagonal(p_e) + self.heat_T @ diagonal(T_e)
        one = sparse.eye_array(self.n.size)
        return sparse.block_array(
            [
                [None, None, over @ self.motion],
                [over @ heat_n, over @ heat_e, over @ self.enthalpy_motion],
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

    def leading(self, shift: complex | None = None, count: int = NEAREST) -> list[Mode]:
        """The modes nearest to the shift, those of largest growth rate first. RunFailed if they are not found."""
        shift = self.default_shift if shift is None else shift
        size, kind = 3 * self.n.size, complex if isinstance(shift, complex) else float
        solve = self.resolvent(shift)
        operator = LinearOperator((size, size), matvec=lambda y: self.relevant(solve(y)), dtype=kind)
        start = self.relevant(np.random.default_rng(1).standard_normal(size).astype(kind))
        zeros = sparse.csr_array((size, size), dtype=kind)  # for its shape only
        try:
            values, vectors = eigs(zeros, k=min(count, size - 2), sigma=shift, OPinv=operator, v0=start)
        except ArpackError as error:
            raise RunFailed(f"no growth rates found, {self.sector.name} perturbations: {error}") from None
        modes = [self._mode(value, vector) for value, vector in zip(values, vectors.T, strict=True)]
        return sorted(modes, key=lambda mode: -mode.growth_rate.real)

    def relevant(self, y: np.ndarray) -> np.ndarray:
        """(n', e', psi) without the means of n' and psi; as it is where mass may cross the mirror."""
        if self.sector.leak.any():
            return y
        share = self.areas / self.areas.sum()
        n, e, psi = np.split(y, 3)
        return np.concatenate([n - share @ n, e, psi - share @ psi])

    @property
    def default_shift(self) -> float:
        """A rate of the order of slow growth: a small share of the collisional cooling rate of the whole gas."""
        cooling = self.areas @ self.state.gas.cooling(self.n, self.T)
        return 0.02 * float(cooling / (self.areas @ (self.n * self.T)))

    def _mode(self, value: complex, vector: np.ndarray) -> Mode:
        n, e, psi = np.split(vector, 3)
        phase = n[np.argmax(np.abs(n))]
        phase = phase / abs(phase) if abs(phase) > 0.0 else 1.0
        n, e, psi = n / phase, e / phase, psi / phase
        fields = [field.reshape(self.state.mesh.cells) for field in (n, (e - self.T * n) / self.n, psi)]
        if abs(value.imag) < 1e-12 * abs(value):
            fields = [field.real for field in fields]
        return Mode(complex(value), self.sector.name, *fields)


def interleaved(matrix: sparse.csc_array) -> sparse.csc_array:
    """A matrix of 2 x 2 blocks with the two unknowns of each cell next to each other: less fill in its factors."""
    cells = matrix.shape[0] // 2
    order = np.arange(2 * cells).reshape(2, cells).T.ravel()
    return matrix[order][:, order].tocsc()
