"""The multigrid of the implicit step."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hydro.driver.march import Run, advance
from hydro.dynamics import LagrangeRemap, multigrid
from hydro.dynamics.multigrid.hierarchy import dense
from hydro.dynamics.multigrid.stencil import build
from hydro.gas import Grossman
from hydro.initial.cosine import cosine_averages
from hydro.mesh import Mesh
from hydro.state import State
from hydro.steady.localized import steady_state
from hydro.terms import Friction
from hydro.walls import VibratingWall


@pytest.mark.parametrize("stretch", [1.0, 5.0])
@pytest.mark.parametrize("periodic", [(False, False), (False, True), (True, True)])
def test_multigrid_solves_the_equations_of_the_implicit_step(stretch, periodic):
    """Cycles under exact residuals end in the solution that a sparse solver finds."""
    rng = np.random.default_rng(5)
    hierarchy = multigrid.Hierarchy(Mesh.rectangle((12, 10), 1.3, stretch, periodic))
    finest = hierarchy.levels[0]
    local, sides = finest.equations.local, (finest.equations.faces_x, finest.equations.faces_y)
    local[:] = rng.uniform(0.1, 0.2, local.shape) * np.array([1.0, -0.3, 0.3, 1.0])[:, None]
    for axis, faces in enumerate(sides):
        faces[:, :3] = rng.uniform(0.5, 1.0, faces[:, :3].shape)
        faces[:, 3:] = 0.05 * rng.standard_normal(faces[:, 3:].shape)
        if not periodic[axis]:
            faces[0 if axis == 0 else (slice(None), slice(None), 0)] = 0.0
    build(finest.equations)
    hierarchy.prepare()
    matrix = dense(finest)
    wanted = rng.standard_normal(finest.right.size)
    right, found = matrix @ wanted, np.zeros(finest.right.size)
    for _ in range(25):
        finest.right[:] = (right - matrix @ found).reshape(finest.right.shape)
        hierarchy.cycle()
        found += finest.unknowns[:, :, 1:-1].reshape(-1)
    assert found == pytest.approx(wanted, rel=1e-5, abs=1e-5)


def test_iterations_of_the_implicit_step_do_not_grow_with_the_grid():
    """A dense cluster, n from 0.004 to 0.9995, at steps of many times what heat and sound take to cross it."""
    gas, wall, counts = Grossman(L=5e4, K=2e-3), VibratingWall(strength=0.228), []
    for nx in (32, 64, 128):
        state = steady_state(gas, wall, Mesh.rectangle((nx, 2 * nx), 2.0), 0.04, 1).state
        warmer = state.temperature * (1.0 + 0.01 * cosine_averages(state.mesh, 3))
        state = State.of(gas, state.mesh, state.density, warmer)
        integrator = LagrangeRemap(gas, wall, state.mesh, terms=[Friction(200.0)], tolerance=1e9)
        run = Run(state, integrator, math.inf, dt_max=10.0)
        for _ in range(30):
            advance(run, math.inf)
        before = integrator.iterations
        for _ in range(10):
            advance(run, math.inf)
        counts.append((integrator.iterations - before) / 10)
    assert max(counts) <= 8.0 and counts[-1] <= 1.3 * counts[0]
