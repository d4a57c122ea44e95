"""Cells whose heat is a small share of their energy: their balance is that of internal energy.

Where grains are packed and cold but move as a whole, the kinetic energy is many times the heat, and temperature, their
total less the kinetic energy, would be made of errors. In such cells

    d(nT)/dt + div(nT v) = -p div v + div(kappa grad T) - I + viscous heating

takes the place of the balance of total energy, with the velocities of the same faces (the dual-energy formalism; Bryan
et al., Comput. Phys. Commun. 89, 149, 1995). Elsewhere nothing changes. The difference to the balance of total energy
is booked under an account of its own. A cell that moves at the speed of sound or faster keeps total energy: what
shocks do, no balance of internal energy tells.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydro.dynamics.lagrange.rows import copy_row
from hydro.dynamics.lagrange.transport import pad_row, profile_line, profile_row, upstream_row
from hydro.dynamics.lagrange.workspace import DENSITY_HIGH, DENSITY_LOW, PADDED, PROFILES, WEIGHT, Work
from hydro.fields import MX, MY, E, N, P
from hydro.gas import Closure
from hydro.gas.conduction import conducted_heat
from hydro.jit import kernel, part
from hydro.mesh import GHOSTS, Faces, Geometry, Mesh
from hydro.walls.boundary import FLOW, HEAT, HIGH, LOW, Sides

SHARE = 0.25  # of the kinetic energy: a cell with less heat is cold
SLOW = 0.5  # Mach number below which a cold cell has a balance of internal energy
FALL = 0.3  # of its temperature: the least that is extrapolated
INTERNAL, VOLUME = 0, 1  # rows of `carried`: what a unit of momentum at the face takes along


class Arrays(NamedTuple):
    """Work space for cold cells of a mesh of (nx, ny)."""

    cold: np.ndarray  # (nx, ny), whether a cell is
    base: np.ndarray  # (nx, ny), what the last two states contribute to its internal energy
    carried_x: np.ndarray  # (2, nx + 1, ny)
    carried_y: np.ndarray  # (2, nx, ny + 1)

    @classmethod
    def of(cls, mesh: Mesh) -> Arrays:
        nx, ny = mesh.cells
        return cls(
            np.zeros((nx, ny), bool), np.zeros((nx, ny)), np.zeros((2, nx + 1, ny)), np.zeros((2, nx, ny + 1))
        )  # fmt: skip


class ColdCells:
    """The cells of a mesh that are cold, found anew in every step."""

    def __init__(self, gas: Closure, geometry: Geometry, sides: Sides, mesh: Mesh):
        self.gas, self.geometry, self.sides, self.mesh = gas, geometry, sides, mesh
        self.any = False
        self._arrays: Arrays | None = None

    @property
    def arrays(self) -> Arrays:
        """Work space, made when it is first needed."""
        if self._arrays is None:
            self._arrays = Arrays.of(self.mesh)
        return self._arrays

    def look_ahead(self, now: np.ndarray, last: np.ndarray, ratio: float, ahead: np.ndarray) -> bool:
        """Find them; extrapolate their temperature, not their energy. Whether n and T of all cells are in bounds."""
        count, good = look_ahead_cold(self.gas, self.geometry.periodic_x, now, last, ratio, ahead, self.arrays)
        self.any = count > 0
        return good

    def carry(self, limiter, velocity: Faces, work: Work) -> None:
        """What faces carry along of internal energy."""
        if self.any:
            carry_internal(self.gas, limiter, self.geometry, velocity, work, self.arrays)

    def add_heat(self, heat: np.ndarray, h: float) -> None:
        """Heat at a rate (nx, ny) over `h`."""
        if self.any:
            self.arrays.base[:] += h * heat

    def balance(self, P: np.ndarray, T: np.ndarray, h: float, drag: float, work: Work, right: np.ndarray) -> None:
        """Put what is missing in the balances of internal energy in place of that of total energy."""
        if self.any:
            internal_balance(self.geometry, self.sides, P, T, h, drag, work, self.arrays, right)

    def energy_added(self, right: np.ndarray) -> float:
        """What they get that the balances of total energy, of which `right` is missing, do not have."""
        return -float(right[:, 1][self.arrays.cold].sum()) if self.any else 0.0


@part(exact=True)
def temperature_and_speed(state, i, j):
    """Temperature and speed of a cell of a conserved state."""
    n = state[N, i, j]
    u, v = state[MX, i, j] / n, state[MY, i, j] / n
    square = u * u + v * v
    return state[E, i, j] / n - 0.5 * square, np.sqrt(square)


@kernel(exact=True)
def look_ahead_cold(gas, periodic, now, last, ratio, ahead, a):
    """See `ColdCells.look_ahead`; returns how many cells are cold, and whether all are in bounds."""
    nx, ny = a.cold.shape
    weight, packed = ratio * ratio / (1.0 + 2.0 * ratio), gas.packing_density()
    count, good = 0, True
    for i in range(nx):
        k = i + GHOSTS
        for j in range(ny):
            T, speed = temperature_and_speed(now, i, j)
            n = now[N, i, j]
            heat_is_little = 0.5 * SHARE * speed * speed > T
            cold = heat_is_little and speed < SLOW * gas.sound_speed(n, T)
            a.cold[i, j] = cold
            foreseen = ahead[N, k, j]
            if cold and 0.0 < foreseen < packed:
                T_last, _ = temperature_and_speed(last, i, j) if ratio > 0.0 else (T, 0.0)
                before = last[N, i, j] * T_last if ratio > 0.0 else n * T
                a.base[i, j] = n * T + weight * (n * T - before)
                ahead[P, k, j] = gas.pressure(foreseen, max(FALL * T, T + ratio * (T - T_last)))
                count += 1
            good = good and 0.0 < foreseen < packed and 0.0 < ahead[P, k, j] < np.inf
    for ghost in range(GHOSTS):
        below, above = (nx + ghost, GHOSTS + ghost) if periodic else (GHOSTS, nx + GHOSTS - 1)
        copy_row(ahead[P, below], ahead[P, ghost])
        copy_row(ahead[P, above], ahead[P, nx + GHOSTS + ghost])
    return count, good


@kernel(exact=True)
def carry_internal(gas, limiter, geometry, velocity, work, a):
    """Swept internal energy, and the volume, of a unit of momentum at the faces; after `carry`."""
    nx, ny = a.cold.shape
    ahead, lines = work.ahead, work.lines
    for i in range(nx + 1):
        here = i + GHOSTS
        upstream_row(velocity.x[i], lines[WEIGHT])
        for q in (N, P):
            profile_row(limiter, ahead[q], here, geometry.spacing_x, lines[WEIGHT], lines[PROFILES + q])
        for j in range(ny):
            over = 2.0 / (ahead[N, here - 1, j] + ahead[N, here, j])
            length = geometry.scale_x[i] * geometry.dy[j]
            a.carried_x[INTERNAL, i, j] = length * over * swept_heat(gas, lines, j)
            a.carried_x[VOLUME, i, j] = length * over
    for i in range(nx):
        upstream_row(velocity.y[i], lines[WEIGHT])
        for q in (N, P):
            pad_row(ahead[q, i + GHOSTS], geometry.periodic_y, lines[PADDED])
            profile_line(
                limiter, lines[PADDED], geometry.spacing_y[1], geometry.spacing_y[2], lines[WEIGHT], lines[PROFILES + q]
            )
            if q == N:
                for j in range(ny + 1):
                    lines[DENSITY_LOW, j], lines[DENSITY_HIGH, j] = lines[PADDED, j + 1], lines[PADDED, j + 2]
        for j in range(ny + 1):
            over = 2.0 / (lines[DENSITY_LOW, j] + lines[DENSITY_HIGH, j])
            a.carried_y[INTERNAL, i, j] = geometry.dx[i] * over * swept_heat(gas, lines, j)
            a.carried_y[VOLUME, i, j] = geometry.dx[i] * over


@part(exact=True)
def swept_heat(gas, lines, j):
    """n T of the profiles at a face."""
    return lines[PROFILES + P, j] / gas.compressibility(lines[PROFILES + N, j])


@kernel(exact=True)
def internal_balance(geometry, sides, P, T, h, drag, work, a, right):
    """See `ColdCells.balance`; after `balance`, into `right` (nx, 2, ny)."""
    nx, ny = P.shape
    for i in range(nx):
        for j in range(ny):
            if a.cold[i, j]:
                kept = work.density[i, j] * T[i, j] - a.base[i, j] + h * work.cooling[i, j]
                area = geometry.scale[i] * geometry.dx[i] * geometry.dy[j]
                given = faces_across(geometry, sides, P, T, h, drag, work, a, i, j)
                given += faces_along(geometry, sides, P, T, h, drag, work, a, i, j)
                right[i, 1, j] = h * given - area * kept


@part(exact=True)
def faces_across(geometry, sides, P, T, h, drag, work, a, i, j):
    """Power into a cell through its faces in x: heat, what gas carries in, and the work of its own pressure."""
    nx, power, slow = P.shape[0], 0.0, 1.0 / (1.0 + h * drag)
    for face, toward in ((i, 1.0), (i + 1, -1.0)):
        low, high = (face - 1) % nx, face % nx
        aperture = geometry.aperture_x[geometry.pattern_x[face], j]
        inverse, length = geometry.inverse_x[face], geometry.scale_x[face] * geometry.dy[j]
        pushed = aperture * slow * (work.momentum.x[face, j] - h * (P[high, j] - P[low, j]) * inverse)
        kappa_low, kappa_high = work.kappa[low, j], work.kappa[high, j]
        heat = -aperture * length * conducted_heat(inverse, kappa_low, kappa_high, T[low, j], T[high, j])
        if face == 0 or face == nx:
            side = sides.x[HIGH if face > 0 else LOW]
            pushed += side[FLOW, j]
            heat += toward * side[HEAT, j] * length
        power += toward * (heat + pushed * (a.carried_x[INTERNAL, face, j] + P[i, j] * a.carried_x[VOLUME, face, j]))
    return power


@part(exact=True)
def faces_along(geometry, sides, P, T, h, drag, work, a, i, j):
    """The same through its faces in y."""
    ny, power, slow = P.shape[1], 0.0, 1.0 / (1.0 + h * drag)
    for face, toward in ((j, 1.0), (j + 1, -1.0)):
        low, high = (face - 1) % ny, face % ny
        aperture = geometry.aperture_y[geometry.pattern_y[i], face]
        inverse = geometry.inverse_y[face] / geometry.scale[i]
        pushed = aperture * slow * (work.momentum.y[i, face] - h * (P[i, high] - P[i, low]) * inverse)
        kappa_low, kappa_high = work.kappa[i, low], work.kappa[i, high]
        heat = -aperture * geometry.dx[i] * conducted_heat(inverse, kappa_low, kappa_high, T[i, low], T[i, high])
        if face == 0 or face == ny:
            side = sides.y[HIGH if face > 0 else LOW]
            pushed += side[FLOW, i]
            heat += toward * side[HEAT, i] * geometry.dx[i]
        power += toward * (heat + pushed * (a.carried_y[INTERNAL, i, face] + P[i, j] * a.carried_y[VOLUME, i, face]))
    return power
