"""The full equations against a solution made up beforehand: every term at once, at second order.

Density, velocity and temperature are chosen as smooth functions of x, y and t that satisfy the conditions of the
elastic walls. Put into the equations, with conduction, cooling and friction, they leave a remainder; given to the
method as a source, it makes them the solution. Derivatives are complex-step derivatives, exact to round-off; the
source is averaged over cells with four Gauss points, each cell on its own, at mid-step.
"""

from __future__ import annotations

import itertools
from typing import Any, NamedTuple

import numpy as np

from hydro.dynamics.limiters import LIMITERS
from hydro.dynamics.riemann import RIEMANN_SOLVERS
from hydro.gas import Grossman
from hydro.mesh import Mesh
from hydro.state import State
from hydro.verification.claims import Claim, Findings, Row, Table, at_least, measurement, orders
from hydro.verification.march import godunov, l1, run

TOPIC = "Manufactured solution"
GAS = Grossman(L=200.0, K=0.05)
TAU = 2.0
DELTA = 1.5
STEP = 1e-30  # of the complex-step derivatives
END = 0.2
ORDER = 1.9
OFFSETS = (-0.5 / 3.0**0.5, 0.5 / 3.0**0.5)  # of the two Gauss points, in cell widths


class Fields(NamedTuple):
    """Primitive variables and the temperature gradient."""

    n: Any
    u: Any
    v: Any
    T: Any
    T_x: Any
    T_y: Any


def chosen(x, y, t) -> Fields:
    """The solution. Normal velocities and normal gradients vanish at x = 0, 1 and y = 0, DELTA."""
    kx, ky = np.pi, np.pi / DELTA
    beat, swing = np.cos(2.0 * t), np.sin(1.0 + 3.0 * t)
    n = 0.3 + 0.1 * np.cos(kx * x) * np.cos(ky * y) * beat
    u = 0.4 * np.sin(kx * x) * np.cos(2.0 * ky * y) * swing
    v = 0.3 * np.cos(kx * x) * np.sin(ky * y) * beat
    T = 1.0 + 0.2 * np.cos(kx * x) * np.cos(2.0 * ky * y) * swing
    T_x = -0.2 * kx * np.sin(kx * x) * np.cos(2.0 * ky * y) * swing
    T_y = -0.4 * ky * np.cos(kx * x) * np.sin(2.0 * ky * y) * swing
    return Fields(n, u, v, T, T_x, T_y)


def conserved(x, y, t) -> np.ndarray:
    """Density, momenta and energy, stacked."""
    n, u, v, T, _, _ = chosen(x, y, t)
    return np.stack(np.broadcast_arrays(n, n * u, n * v, n * T + 0.5 * n * (u * u + v * v)))


def fluxes(x, y, t, axis: int) -> np.ndarray:
    """Fluxes along `axis` of the conserved fields, heat conduction included."""
    field = chosen(x, y, t)
    p, e = GAS.pressure(field.n, field.T), conserved(x, y, t)[3]
    across, gradient = ((field.u, field.T_x), (field.v, field.T_y))[axis]
    mass = field.n * across
    pressure = (p, 0.0) if axis == 0 else (0.0, p)
    heat = GAS.conductivity(field.n, field.T) * gradient
    return np.stack(
        np.broadcast_arrays(mass, mass * field.u + pressure[0], mass * field.v + pressure[1], (e + p) * across - heat)
    )


def remainder(x, y, t) -> np.ndarray:
    """d/dt of the conserved fields + divergence of their fluxes + friction and cooling."""
    by_step = (
        conserved(x, y, t + 1j * STEP),
        fluxes(x + 1j * STEP, y, t, 0),
        fluxes(x, y + 1j * STEP, t, 1),
    )
    field = chosen(x, y, t)
    lost = GAS.cooling(field.n, field.T) + field.n * (field.u**2 + field.v**2) / TAU
    rubbed = np.stack(np.broadcast_arrays(0.0 * field.n, field.n * field.u / TAU, field.n * field.v / TAU, lost))
    return sum(part.imag for part in by_step) / STEP + rubbed


def averaged(function, mesh: Mesh, t: float) -> np.ndarray:
    """Cell averages of function(x, y, t) by four Gauss points."""
    total = np.zeros((4, *mesh.cells))
    for a, b in itertools.product(OFFSETS, repeat=2):
        total += 0.25 * function((mesh.x + a * mesh.dx)[:, None], (mesh.y + b * mesh.dy)[None, :], t)
    return total


def source(t: float, mesh: Mesh) -> np.ndarray:
    """What the integrator adds, shape (4, nx, ny)."""
    return averaged(remainder, mesh, t)


def errors(cells: int, stretch: float, **options: str) -> list[float]:
    """L1 errors of the four conserved fields at END on `cells` x 3/2 `cells`."""
    mesh = Mesh.rectangle((cells, 3 * cells // 2), DELTA, stretch)
    state = State(GAS, mesh, averaged(conserved, mesh, 0.0))
    run(godunov(mesh, GAS, tau=TAU, source=source, **options), state, END)
    return [l1(mesh, error) for error in state.conserved - averaged(conserved, mesh, END)]


@measurement(TOPIC, "Order of the whole method")
def convergence(full: bool) -> Findings:
    """L1 errors of density, momenta and energy in an elastic box 1 x 1.5, L = 200, K = 0.05, tau = 2, to t = 0.2.

    Space and time are refined together (default step), on a mesh whose widths grow twofold from x = 0 to x = 1.
    The order of the sum of the four errors is claimed, in the quick version for the default limiter only.
    """
    counts = (16, 32, 64)
    limiters = list(LIMITERS) if full else ["van_leer"]
    claims: list[Claim] = []
    rows: list[Row] = []
    for riemann, limiter in itertools.product(RIEMANN_SOLVERS, limiters):
        every = [errors(count, 2.0, limiter=limiter, riemann=riemann) for count in counts]
        rows += [(riemann, limiter, count, *fields) for count, fields in zip(counts, every, strict=True)]
        order = orders([1.0 / count for count in counts], [sum(fields) for fields in every])[-1]
        if limiter != "minmod":
            claims.append(at_least(TOPIC, f"manufactured solution, {limiter}, {riemann}: order", "2", order, ORDER))
    header = ("Riemann solver", "limiter", "cells in x", "n", "n u", "n v", "e")
    return Findings(tuple(claims), (Table("L1 errors at t = 0.2.", header, rows),))
