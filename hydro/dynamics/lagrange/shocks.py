"""Shocks and other jumps: what the implicit integrator does where the gas is not smooth, and only there.

Flow that is smooth on the grid, and flow that conduction keeps smooth, is left as it is to the last bit. Elsewhere

- compression is resisted by an artificial viscosity (von Neumann and Richtmyer, J. Appl. Phys. 21, 232, 1950), with
  the speed of Kuropatenko, for any closure, and the limiter of Caramana, Shashkov and Whalen, J. Comput. Phys. 144, 70
  (1998). It is a bulk viscosity of

      zeta = n l q (|du| G + ((|du| G)^2 + (c/2)^2)^(1/2)),    G = (Gamma + 1)/4,

  with l the width of the cell, du its velocity jump and q the share of that which is rough, (1 - limiter). It acts
  implicitly, as the viscosity of the gas does (see `hydro.terms.viscosity`), and heats what it slows down;

and where neighbours differ by a large factor ("violent" cells)

- momentum that streams along a row is that of the faces upstream, so that a face takes no velocity which its neighbours
  upstream and it do not have;
- a face shares its momentum with its two cells in proportion to their mass, not evenly, so that both have its velocity;
- what the extrapolation misses is not counted as an error of the step, for nobody can foresee a jump; instead, sound
  crosses no more than a share of these cells in a step.
"""

from __future__ import annotations

import numpy as np

from hydro.dynamics.lagrange.extrapolation import TIGHT
from hydro.dynamics.lagrange.workspace import Work
from hydro.fields import MX, MY, E, N, P, U, V
from hydro.gas import Closure
from hydro.jit import inline, kernel
from hydro.mesh import GHOSTS, Faces, Geometry, Mesh
from hydro.terms.viscosity.artificial import BulkViscosity
from hydro.walls.boundary import FLOW, HIGH, LOW, Boundary, Sides

LINEAR = 0.5  # weight of the sound speed in the artificial viscosity
ROUGH = (0.005, 0.01)  # rough part of a velocity jump, over the sound speed, where the viscosity sets in and is full
STRONG = (0.15, 0.3)  # the same where conduction alone can no longer spread the shock
CONDUCTED = (0.02, 0.05)  # kappa/(n c l), where conduction begins to spread weaker ones and where it does so alone
VIOLENT = (0.25, 0.5)
CONTRAST = 6.0  # weight, beside that, of the Mach number times a quarter of the relative jump of density
CROSSING = 0.2


class Shocks:
    """Where the gas is not smooth, and what is done there; 32 bytes per cell, 390 more from the first shock on."""

    def __init__(self, gas: Closure, boundary: Boundary, mesh: Mesh):
        self._gas, self._boundary, self._mesh, self._geometry = gas, boundary, mesh, Geometry.of(mesh)
        self._pressure, self._sound, self._flux = (np.zeros(mesh.cells) for _ in range(3))
        self._viscosity: BulkViscosity | None = None
        self._surveyed = False
        self.rate = 0.0  # at which sound crosses violent cells; zero without any

    def forget(self) -> None:
        """The next state is not the one that was surveyed last."""
        self._surveyed = False

    def survey(self, conserved: np.ndarray, work: Work) -> None:
        """Find out where the gas is violent, into `work`; once for every state."""
        if self._surveyed:
            return
        find_sound(self._gas, conserved, self._pressure, self._sound)
        if not may_be_violent(self._geometry, conserved, self._pressure, self._sound):
            work.violence[:], self.rate, self._surveyed = 0.0, 0.0, True
            return
        self.rate = find_violence(
            self._gas, self._geometry, conserved, self._pressure, self._sound, self._flux, work.violence
        )
        self._surveyed = True

    def steer(self, limiter, velocity: Faces, h: float, work: Work) -> None:
        """Let the momentum that streams in violent cells be that of the faces upstream, over `h`."""
        if self.rate == 0.0:
            return
        g, inside = self._geometry, work.ahead[:, GHOSTS:-GHOSTS]
        steer_rows(
            limiter, inside[N], inside[U], velocity.x, work.violence, g.spacing_x, g.inverse_x, g.periodic_x, h,
            self._flux, work.momentum.x,
        )  # fmt: skip
        steer_rows(
            limiter, inside[N].T, inside[V].T, velocity.y.T, work.violence.T, g.spacing_y, g.inverse_y, g.periodic_y, h,
            self._flux.T, work.momentum.y.T,
        )  # fmt: skip

    def resist(self, velocity: Faces, h: float, drag: float, work: Work) -> np.ndarray | None:
        """Artificial viscosity over `h`, into what the balances start from; returns its rate of heat, if any."""
        if not is_rough(self._geometry, velocity, self._sound):
            return None
        self._viscosity = self._viscosity or BulkViscosity(self._boundary, self._mesh)
        density = work.ahead[N, GHOSTS:-GHOSTS]
        rough = self._viscosity.work
        if not find_viscosity(self._gas, self._geometry, density, self._sound, velocity, rough, self._viscosity.zeta):
            return None
        leave_streams_alone(self._boundary.sides, self._viscosity.zeta)
        halfway = 0.5 * (self._pressure + work.foreseen(P))
        return self._viscosity.resist(velocity, density, halfway, h, drag, work.momentum, work.base[E])

    @property
    def pressure(self) -> np.ndarray:
        """Pressure of the surveyed state, (nx, ny)."""
        return self._pressure

    @property
    def sound(self) -> np.ndarray:
        """Its sound speed, (nx, ny)."""
        return self._sound


@inline(exact=True)
def ramp(value, ends):
    """From zero at the first of `ends` to one at the second."""
    return max(0.0, min(1.0, (value - ends[0]) / (ends[1] - ends[0])))


@inline(exact=True)
def beside(i, count, periodic):
    """The place of a cell, or of the one that stands for it beyond a side."""
    if periodic:
        return i % count
    return max(0, min(count - 1, i))


@kernel(exact=True)
def find_sound(gas, conserved, pressure, sound):
    """Pressure and sound speed of all cells."""
    for i in range(pressure.shape[0]):
        density, momentum_x, momentum_y = conserved[N, i], conserved[MX, i], conserved[MY, i]
        energy, p, c = conserved[E, i], pressure[i], sound[i]
        for j in range(np.uint64(density.size)):
            n = density[j]
            over = 1.0 / n
            u, v = momentum_x[j] * over, momentum_y[j] * over
            p[j] = gas.pressure(n, energy[j] * over - 0.5 * (u * u + v * v))
            c[j] = gas.sound_speed_at_pressure(n, p[j])


@kernel(exact=True)
def may_be_violent(geometry, conserved, pressure, sound):
    """A quick look: False only where `find_violence` would find nothing."""
    nx, ny = pressure.shape
    for i in range(nx):
        k, count = beside(i + 1, nx, geometry.periodic_x), 0
        p, q, n, m = pressure[i], pressure[k], conserved[N, i], conserved[N, k]
        u, v, w, z = conserved[MX, i], conserved[MY, i], conserved[MX, k], conserved[MY, k]
        c, d = sound[i], sound[k]
        for j in range(np.uint64(ny)):
            here, there = (u[j] * u[j] + v[j] * v[j]), (w[j] * w[j] + z[j] * z[j])
            count += may_jump(p[j], q[j], n[j], m[j], here, there, c[j], d[j])
        for j in range(np.uint64(ny - 1)):
            a = j + np.uint64(1)
            here, there = (u[j] * u[j] + v[j] * v[j]), (u[a] * u[a] + v[a] * v[a])
            count += may_jump(p[j], p[a], n[j], n[a], here, there, c[j], c[a])
        if geometry.periodic_y:
            a, b = ny - 1, 0
            here, there = (u[a] * u[a] + v[a] * v[a]), (u[b] * u[b] + v[b] * v[b])
            count += may_jump(p[a], p[b], n[a], n[b], here, there, c[a], c[b])
        if count > 0:
            return True
    return False


@inline(exact=True)
def may_jump(p, q, n, m, square, square_beside, c, d):
    """One if two cells, of squared momenta that are given, may be violent: no smaller bounds than `find_violence`."""
    least = 0.99 * VIOLENT[0]
    jump = (0.25 * CONTRAST) * (0.25 * CONTRAST) * (n - m) * (n - m)
    smaller = least * least * min(n, m) * min(n, m)
    slow = (jump * square <= smaller * (n * c) * (n * c)) & (jump * square_beside <= smaller * (m * d) * (m * d))
    return 0 if slow & (abs(p - q) <= least * min(p, q)) else 1


@kernel(exact=True)
def find_violence(gas, geometry, conserved, pressure, sound, own, violence):
    """How violent cells are, from 0 to 1: as the most violent of them and their neighbours. own: work.

    Returns the largest rate at which sound crosses one that is, or zero. Where grains are packed, a jump of pressure is
    a small change of the gap, and sound as fast as the gap is small: there both count less.
    """
    nx, ny = pressure.shape
    found = False
    for i in range(nx):
        behind, ahead = beside(i - 1, nx, geometry.periodic_x), beside(i + 1, nx, geometry.periodic_x)
        for j in range(ny):
            below, above = beside(j - 1, ny, geometry.periodic_y), beside(j + 1, ny, geometry.periodic_y)
            n, u, v = conserved[N, i, j], conserved[MX, i, j], conserved[MY, i, j]
            mach = np.sqrt(u * u + v * v) / (n * sound[i, j])
            largest = 0.0
            for k, m in ((behind, j), (ahead, j), (i, below), (i, above)):
                gap = min(gas.gap(n), gas.gap(conserved[N, k, m]))
                push = relative_jump(pressure[i, j], pressure[k, m]) * min(1.0, gap / TIGHT)
                largest = max(largest, max(push, 0.25 * CONTRAST * mach * relative_jump(n, conserved[N, k, m])))
            own[i, j] = violence[i, j] = ramp(largest, VIOLENT)
            found |= own[i, j] > 0.0
    rate = 0.0
    if found:
        for i in range(nx):
            behind, ahead = beside(i - 1, nx, geometry.periodic_x), beside(i + 1, nx, geometry.periodic_x)
            for j in range(ny):
                below, above = beside(j - 1, ny, geometry.periodic_y), beside(j + 1, ny, geometry.periodic_y)
                around = max(max(own[behind, j], own[ahead, j]), max(own[i, below], own[i, above]))
                violence[i, j] = max(own[i, j], around)
                if violence[i, j] > 0.0:
                    n, u, v = conserved[N, i, j], conserved[MX, i, j], conserved[MY, i, j]
                    speed = np.sqrt(u * u + v * v) / n + sound[i, j] * np.sqrt(min(1.0, gas.gap(n) / TIGHT))
                    rate = max(rate, speed / min(geometry.dx[i], geometry.dy[j]))
    return rate


@inline(exact=True)
def relative_jump(a, b):
    """Difference of two positive numbers over the smaller."""
    return abs(a - b) / min(a, b)


@kernel(exact=True)
def steer_rows(limiter, density, along, velocity, violence, spacing, inverse, periodic, h, flux, momentum):
    """Streaming momentum along the first direction, from that of cells to that of faces where cells are violent.

    density, along (its velocity): extrapolated, of cells (n, m). velocity, momentum: of faces (n+1, m). flux: work.
    """
    count, m = violence.shape
    for i in range(count):
        for j in range(m):
            flux[i, j] = 0.0
            if violence[i, j] > 0.0:
                mass_low, pushed_low = swept(limiter, density, along, velocity, spacing, periodic, i, j)
                mass_high, pushed_high = swept(limiter, density, along, velocity, spacing, periodic, i + 1, j)
                low, high = velocity[i, j], velocity[i + 1, j]
                mass, step = 0.5 * (mass_low + mass_high), high - low
                if mass > 0.0:
                    before = velocity[i - 1 if i > 0 else (count - 1 if periodic else 0), j]
                    carried = low + 0.5 * limiter.limited(low - before, step)
                else:
                    after = velocity[i + 2 if i < count - 1 else (1 if periodic else count), j]
                    carried = high - 0.5 * limiter.limited(step, after - high)
                flux[i, j] = violence[i, j] * (mass * carried - 0.5 * (pushed_low + pushed_high))
    for i in range(0 if periodic else 1, count + 1 if periodic else count):
        for j in range(m):
            momentum[i, j] += h * inverse[i] * (flux[i - 1, j] - flux[i % count, j])


@inline(exact=True)
def swept(limiter, density, along, velocity, spacing, periodic, i, j):
    """Mass and momentum that stream through a face, as `transport` has them."""
    count, here = density.shape[0], i + GHOSTS
    a, b = beside(i - 2, count, periodic), beside(i - 1, count, periodic)
    c, d = beside(i, count, periodic), beside(i + 1, count, periodic)
    low1, high1, low2, high2 = spacing[1, here - 1], spacing[2, here - 1], spacing[1, here], spacing[2, here]
    speed = velocity[i, j]
    weight = 1.0 if speed > 0.0 else (0.5 if speed == 0.0 else 0.0)
    n = profile(limiter, density[a, j], density[b, j], density[c, j], density[d, j], low1, high1, low2, high2, weight)
    u = profile(limiter, along[a, j], along[b, j], along[c, j], along[d, j], low1, high1, low2, high2, weight)
    return n * speed, n * speed * u


@inline(exact=True)
def profile(limiter, f0, f1, f2, f3, low1, high1, low2, high2, weight):
    """Limited profile at the face between the cells of f1 and f2; `weight` is the share of the former."""
    step = f2 - f1
    below = f1 + 0.5 * limiter.limited((f1 - f0) * low1, step * high1)
    above = f2 - 0.5 * limiter.limited(step * low2, (f3 - f2) * high2)
    return weight * below + (1.0 - weight) * above


@kernel(exact=True)
def is_rough(geometry, velocity, sound):
    """Whether any cell is compressed fast enough for artificial viscosity."""
    for i in range(sound.shape[0]):
        here, ahead, v, c, fast = velocity.x[i], velocity.x[i + 1], velocity.y[i], sound[i], 0
        for j in range(np.uint64(c.size)):
            least = ROUGH[0] * c[j]
            fast += (here[j] - ahead[j] > least) | (v[j] - v[j + np.uint64(1)] > least)
        if fast > 0:
            return True
    return False


@kernel(exact=True)
def find_viscosity(gas, geometry, density, sound, velocity, rough, zeta):
    """Artificial bulk viscosity of all cells, into `zeta`; returns whether there is any. rough: work, (2, nx, ny)."""
    nx, ny = density.shape
    find_rough(velocity.x, geometry.periodic_x, rough[0])
    find_rough(velocity.y.T, geometry.periodic_y, rough[1].T)
    found = False
    for i in range(nx):
        for j in range(ny):
            n, c, dx, dy = density[i, j], sound[i, j], geometry.dx[i], geometry.dy[j]
            conduction = gas.conductivity_coefficient(n) / (n * gas.sound_speed(n, 1.0))
            rough_x, rough_y = rough[0, i, j], rough[1, i, j]
            rough_x *= needed(roughest(rough[0], geometry.periodic_x, i, j) / c, conduction / dx)
            rough_y *= needed(roughest(rough[1].T, geometry.periodic_y, j, i) / c, conduction / dy)
            in_x, in_y = velocity.x[i, j] - velocity.x[i + 1, j], velocity.y[i, j] - velocity.y[i, j + 1]
            zeta[i, j] = 0.0
            if rough_x + rough_y > 0.0 and in_x / dx + in_y / dy > 0.0:
                in_x, in_y = max(0.0, in_x), max(0.0, in_y)
                steep = 0.25 * (gas.adiabatic_exponent(n) + 1.0) * (in_x + in_y)
                speed = steep + np.sqrt(steep * steep + LINEAR * LINEAR * c * c)
                zeta[i, j] = n * speed * (rough_x + rough_y) / (in_x / dx + in_y / dy)
                found = True
    return found


def leave_streams_alone(sides: Sides, zeta: np.ndarray) -> None:
    """No artificial viscosity in cells that gas streams into, or out of, through a side: its work would be nobody's."""
    for end, place in ((LOW, 0), (HIGH, -1)):
        zeta[place][sides.x[end, FLOW, :-1] != 0.0] = 0.0
        zeta[:, place][sides.y[end, FLOW, :-1] != 0.0] = 0.0


@inline(exact=True)
def find_rough(velocity, periodic, rough):
    """The rough part of the velocity jump by which cells are compressed along the first direction, (n, m).

    velocity: of faces, (n+1, m).
    """
    count, m = rough.shape
    for i in range(count):
        behind, ahead = beside(i - 1, count, periodic), beside(i + 1, count, periodic)
        for j in range(m):
            here = velocity[i + 1, j] - velocity[i, j]
            rough[i, j] = 0.0
            if here < 0.0:
                low = (velocity[behind + 1, j] - velocity[behind, j]) / here
                high = (velocity[ahead + 1, j] - velocity[ahead, j]) / here
                smooth = max(0.0, min(min(1.0, 0.5 * (low + high)), min(2.0 * low, 2.0 * high)))
                rough[i, j] = -here * (1.0 - smooth)


@inline(exact=True)
def roughest(rough, periodic, i, j):
    """The largest of a cell and of two neighbours on either side: those that belong to one shock."""
    largest = 0.0
    for step in range(-2, 3):
        largest = max(largest, rough[beside(i + step, rough.shape[0], periodic), j])
    return largest


@inline(exact=True)
def needed(rough, conduction):
    """The share of the viscosity that is needed: none where the gas is smooth or conduction makes it so."""
    return ramp(rough, ROUGH) * max(1.0 - ramp(conduction, CONDUCTED), ramp(rough, STRONG))
