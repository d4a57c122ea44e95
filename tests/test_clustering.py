"""The observables of clustering: what is read from a density."""

from __future__ import annotations

import numpy as np
import pytest

from hydro.gas import Grossman
from hydro.mesh import Mesh
from hydro.observables.clustering import (
    centre_of_mass,
    cluster_position,
    clusters,
    gas_density,
    half_waves,
    wall_extremes,
)
from hydro.state import State
from hydro.walls import ThermalWall, VibratingWall


@pytest.mark.parametrize("shift", range(0, 64, 7))
def test_clusters_are_counted_also_across_a_seam(shift):
    y = (np.arange(64) + 0.5) / 64
    line = 0.1 + 0.5 * np.exp(-(((y - 0.25) / 0.05) ** 2)) + 0.3 * np.exp(-(((y - 0.7) / 0.05) ** 2))
    tops = clusters(np.roll(line, shift), periodic=True)
    assert sorted((tops - shift) % 64) in ([15, 44], [16, 44], [15, 45], [16, 45])
    assert clusters(line).size == 2 and clusters(np.full(8, 0.3)).size == 0
    assert clusters(np.cos(2.0 * np.pi * y) + 1.5).size == 2  # two halves at walls, or one across a seam
    assert clusters(np.cos(2.0 * np.pi * y) + 1.5, periodic=True).size == 1


def test_the_centre_of_mass():
    mesh = Mesh.rectangle((40, 40), 2.0, 4.0)
    density = 0.1 * (1.0 + mesh.x[:, None] * (mesh.y[None, :] / 2.0))
    x, y = centre_of_mass(State.of(Grossman(0.0, 0.0), mesh, density, 1.0))
    assert (x, y) == pytest.approx((8.0 / 15.0, 16.0 / 15.0), rel=1e-3)


def test_half_waves_along_the_wall():
    mesh = Mesh.rectangle((4, 60), 3.0)
    for m in range(1, 5):
        assert half_waves(1.0 + 0.3 * np.cos(m * np.pi * mesh.y / 3.0), mesh) == m
    assert half_waves(0.02 + np.exp(-((mesh.y / 0.1) ** 2)), mesh) == 1
    assert half_waves(0.02 + np.exp(-(((mesh.y - 1.5) / 0.1) ** 2)), mesh) == 2
    assert half_waves(1.0 + 0.009 * np.cos(np.pi * mesh.y / 3.0), mesh) == 0
    ring = Mesh.rectangle((4, 60), 3.0, periodic=(False, True))
    assert half_waves(1.0 + 0.3 * np.sin(2.0 * np.pi * ring.y / 3.0), ring) == 2


@pytest.mark.parametrize("stretch", [1.0, 5.0])
def test_wall_extremes_converge_with_fourth_order_in_corners_and_inside(stretch):
    errors = []
    for nx in (16, 32):
        mesh = Mesh.rectangle((nx, 2 * nx), 2.0, stretch)
        x = np.diff(np.sin(mesh.x_faces)) / mesh.dx
        corner = np.diff(np.sin(np.pi * mesh.y_faces)) / (np.pi * mesh.dy)
        high = wall_extremes(0.3 + 0.1 * x[:, None] * corner[None, :], mesh)
        errors.append([abs(high[0] - 0.2), abs(high[1] - 0.4)])
    assert np.all(np.array(errors[0]) / np.array(errors[1]) > 12.0)


def test_gas_density_is_that_of_the_wall_face():
    """In a gas that the wall heats, the face is hotter, hence thinner, than the last cell."""
    mesh, gas = Mesh.rectangle((8, 8)), Grossman(5e4, 2e-3)
    state = State.of(gas, mesh, 0.1, 1.0)
    assert gas_density(state, ThermalWall(4.0)) == pytest.approx(gas.density(gas.pressure(0.1, 1.0), 4.0), rel=1e-14)
    assert gas_density(state, VibratingWall(strength=0.0)) == pytest.approx(0.1, rel=1e-12)
    assert gas_density(state, VibratingWall(strength=0.1)) < 0.1


def test_a_cluster_across_a_periodic_seam_has_the_height_of_one_inside():
    mesh = Mesh.rectangle((8, 32), 2.0, periodic=(False, True))
    line = 0.3 + 0.1 * np.cos(np.pi * (mesh.y - 0.99))
    inside = np.broadcast_to(line, mesh.cells)
    seam = np.roll(inside, 16, axis=1)
    assert wall_extremes(seam, mesh) == pytest.approx(wall_extremes(inside, mesh), rel=1e-14)


def test_no_density_beyond_its_bounds_is_extrapolated_to_a_wall():
    mesh = Mesh.rectangle((8, 8))
    steep = np.full(mesh.cells, 0.1)
    steep[0, 0] = 0.95
    low, high = wall_extremes(steep, mesh)
    assert 0.0 < low <= high < 1.0


def test_averages_on_a_wall_count_whatever_they_are():
    """Of grains: none in some cells, and layers denser than n_c."""
    mesh = Mesh.rectangle((8, 8))
    density = np.full(mesh.cells, 0.1)
    density[:2, 2:4], density[:2, 5] = 1.06, 0.0
    assert wall_extremes(density, mesh) == (0.0, 1.06)
    density[:, :] = 0.0
    assert wall_extremes(density, mesh) == (0.0, 0.0)
    density[0], density[1] = 0.01, 0.07  # whose parabola is zero at the wall, but for round-off
    assert wall_extremes(density, mesh) == (0.01, 0.01)


def test_clusters_on_the_wall():
    mesh = Mesh.rectangle((4, 20), 2.0)
    top = 0.73
    line = 0.3 - 0.1 * (mesh.y - top) ** 2
    assert cluster_position(np.ones((4, 1)) * line, mesh) == pytest.approx(top, abs=1e-12)
    assert cluster_position(np.ones((4, 1)) * np.linspace(0.3, 0.1, 20), mesh) == pytest.approx(0.0, abs=1e-12)
    both = 0.3 - 0.1 * np.abs(np.sin(np.pi * mesh.y / 2.0))
    assert cluster_position(np.ones((4, 1)) * both * (1.0 + 1e-9 * mesh.y), mesh) == pytest.approx(0.0, abs=1e-12)
