"""The full equations against a solution made up beforehand: every term at once, at second order.

`hydro.exact.manufactured` says how it is made: pressure, temperature and velocity are smooth functions of x, y and t
that satisfy the conditions at the elastic walls and at the vibrating one, and a source makes them the solution.
"""

from __future__ import annotations

import itertools
import math
from typing import Any

from hydro.choices import LIMITERS, RIEMANN_SOLVERS
from hydro.driver.march import march
from hydro.dynamics.godunov import Godunov
from hydro.dynamics.integrator import Integrator
from hydro.dynamics.lagrange import LagrangeRemap
from hydro.exact import Manufactured
from hydro.gas import Grossman
from hydro.mesh import Mesh
from hydro.state import State
from hydro.studies.orders import orders
from hydro.verification.claims import Claim, Findings, Row, Table, at_least, measurement
from hydro.verification.setups import l1, stepping
from hydro.walls import VibratingWall

TOPIC = "Manufactured solution"
GAS, TAU, WALL = Grossman(L=200.0, K=0.05), 2.0, VibratingWall(strength=0.05 * 3.0)
SOLUTION = Manufactured(GAS, TAU, WALL.strength, aspect_ratio=1.5)
END = 0.2
ORDER = 1.9
COUNTS = (16, 32, 64)
IMPLICIT = "lagrange-remap"


def mesh_of(cells: int) -> Mesh:
    """`cells` x 3/2 `cells`, the widths in x growing twofold."""
    return Mesh.rectangle((cells, 3 * cells // 2), SOLUTION.aspect_ratio, 2.0)


def errors(integrator: Integrator, mesh: Mesh, dt: float | None = None) -> list[float]:
    """L1 errors of the four conserved fields at END."""
    state = State(GAS, mesh, SOLUTION.conserved(mesh, 0.0))
    march(state, stepping(integrator, dt), END)
    return [l1(mesh, error) for error in state.conserved - SOLUTION.conserved(mesh, END)]


def explicit_errors(cells: int, **options: Any) -> list[float]:
    """Of the explicit integrator with its default step."""
    mesh = mesh_of(cells)
    return errors(Godunov(GAS, WALL, mesh, terms=SOLUTION.terms, **options), mesh)


def implicit_errors(cells: int, limiter: str) -> list[float]:
    """Of the implicit integrator with steps in proportion to the cells."""
    mesh = mesh_of(cells)
    integrator = LagrangeRemap(
        GAS, WALL, mesh, terms=SOLUTION.terms, limiter=limiter, tolerance=math.inf
    )  # fmt: skip
    return errors(integrator, mesh, END / (2 * cells))


@measurement(TOPIC, "Order of the whole method")
def convergence(full: bool) -> Findings:
    """L1 errors of density, momenta and energy in a box 1 x 1.5, L = 200, K = 0.05, tau = 2, to t = 0.2.

    The wall at x = 1 vibrates with W = 3, the others are elastic. Space and time are refined together, on a mesh whose
    widths grow twofold from x = 0 to x = 1: `godunov` takes its default step, `lagrange-remap` 2 steps for each cell in
    x. The order of the sum of the four errors is claimed, in the quick version for the default limiter only.
    """
    limiters = list(LIMITERS) if full else ["van_leer"]
    methods: list[tuple[str, str, list[list[float]]]] = [
        (riemann, limiter, [explicit_errors(count, riemann=riemann, limiter=limiter) for count in COUNTS])
        for riemann, limiter in itertools.product(RIEMANN_SOLVERS, limiters)
    ]
    methods += [
        ("lagrange-remap", limiter, [implicit_errors(count, limiter) for count in COUNTS]) for limiter in limiters
    ]
    claims: list[Claim] = []
    rows: list[Row] = []
    for name, limiter, every in methods:
        rows += [(name, limiter, count, *fields) for count, fields in zip(COUNTS, every, strict=True)]
        order = orders([1.0 / count for count in COUNTS], [sum(fields) for fields in every])[-1]
        if limiter != "minmod":
            claims.append(at_least(TOPIC, f"manufactured solution, {limiter}, {name}: order", "2", order, ORDER))
    header = ("method", "limiter", "cells in x", "n", "n u", "n v", "e")
    return Findings(tuple(claims), (Table("L1 errors at t = 0.2.", header, rows),))
