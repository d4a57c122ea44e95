"""Initial states: patterns, and states on another mesh."""

from __future__ import annotations

import numpy as np
import pytest

from hydro.gas import Grossman
from hydro.initial.cosine import cosine_averages
from hydro.initial.regrid import regrid
from hydro.mesh import Mesh
from hydro.state import State


def a_cluster(mesh, steepness=30.0):
    """A dense corner in uniform pressure, a little flow, on any mesh."""
    gas = Grossman(0.0, 0.0)
    r = np.hypot(mesh.x[:, None], mesh.y[None, :])
    n = 0.004 + 0.75 / (1.0 + np.exp(steepness * (r - 0.4)))
    return State.of(gas, mesh, n, gas.temperature(n, 0.004), (0.01 * n, 0.02))


@pytest.mark.parametrize("steepness", [30.0, 1e9])
def test_regrid_conserves_and_keeps_bounds_and_pressure(steepness):
    with np.errstate(over="ignore"):
        old = a_cluster(Mesh.rectangle((48, 96), 2.0), steepness)
    moved = regrid(old, Mesh.rectangle((40, 130), 2.0, 4.0))
    for before, after in zip(old.conserved, moved.conserved, strict=True):
        assert moved.mesh.integral(after) == pytest.approx(old.mesh.integral(before), rel=1e-12)
    assert old.density.min() * (1.0 - 1e-11) <= moved.density.min()
    assert moved.density.max() <= old.density.max() * (1.0 + 1e-11)
    assert np.ptp(moved.pressure) < 1e-10 * moved.pressure.mean()


def test_regrid_converges_and_keeps_an_unchanged_mesh():
    old = a_cluster(Mesh.rectangle((16, 24), 2.0))
    np.testing.assert_array_equal(regrid(old, Mesh.rectangle((16, 24), 2.0)).conserved, old.conserved)
    errors = []
    for nx in (32, 64, 128):
        there = a_cluster(Mesh.rectangle((nx, 2 * nx), 2.0), 10.0)
        target = Mesh.rectangle((3 * nx // 4, nx), 2.0, 2.0)
        wanted = a_cluster(target, 10.0)
        errors.append(np.abs(regrid(there, target).density - wanted.density).mean())
    assert errors[0] / errors[1] > 3.0 and errors[1] / errors[2] > 3.0


@pytest.mark.parametrize(("wave", "sign"), [(0, 1.0), (1, -1.0), (2, 1.0), (3, -1.0)])
def test_cosines_are_even_or_odd_to_the_last_bit(wave, sign):
    cosine = cosine_averages(Mesh.rectangle((2, 50), 1.3), wave)
    np.testing.assert_array_equal(cosine, sign * cosine[::-1])
    assert np.abs(cosine).max() > 0.99
