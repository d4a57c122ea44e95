"""Heat conducted through a face: one formula for numpy and for kernels."""

from __future__ import annotations

import numpy as np
import pytest

from hydro.gas import Grossman
from hydro.gas.conduction import conducted_heat, conducted_slope, face_conductance, face_conductivity
from hydro.jit import kernel
from hydro.mesh import Mesh
from hydro.steady.operators import Faces
from hydro.walls import ThermalWall, VibratingWall

WEIGHT, KAPPA_A, KAPPA_B, T_A, T_B = np.random.default_rng(4).uniform(0.1, 3.0, (5, 64))


@kernel(exact=True)
def conducted(weight, kappa_a, kappa_b, T_a, T_b, heat, conductance, slope):
    for i in range(weight.size):
        heat[i] = conducted_heat(weight[i], kappa_a[i], kappa_b[i], T_a[i], T_b[i])
        conductance[i] = face_conductance(weight[i], kappa_a[i], kappa_b[i])
        slope[i] = conducted_slope(weight[i], T_a[i], T_b[i])


def test_kernels_and_numpy_conduct_the_same_heat_to_the_last_bit():
    found = np.zeros((3, 64))
    conducted(WEIGHT, KAPPA_A, KAPPA_B, T_A, T_B, *found)
    assert np.array_equal(found[0], conducted_heat(WEIGHT, KAPPA_A, KAPPA_B, T_A, T_B))
    assert np.array_equal(found[1], face_conductance(WEIGHT, KAPPA_A, KAPPA_B))
    assert np.array_equal(found[2], conducted_slope(WEIGHT, T_A, T_B))


def test_slopes_of_conducted_heat():
    heat, h = conducted_heat, 1e-5
    in_T = (heat(WEIGHT, KAPPA_A, KAPPA_B, T_A, T_B + h) - heat(WEIGHT, KAPPA_A, KAPPA_B, T_A, T_B - h)) / (2.0 * h)
    in_a = (heat(WEIGHT, KAPPA_A + h, KAPPA_B, T_A, T_B) - heat(WEIGHT, KAPPA_A - h, KAPPA_B, T_A, T_B)) / (2.0 * h)
    assert face_conductance(WEIGHT, KAPPA_A, KAPPA_B) == pytest.approx(in_T, rel=1e-8)
    assert conducted_slope(WEIGHT, T_A, T_B) == pytest.approx(in_a, rel=1e-8, abs=1e-9)


def test_heat_flows_from_hot_to_cold_and_back():
    assert conducted_heat(2.0, 1.0, 3.0, 0.5, 1.5) == 2.0 * face_conductivity(1.0, 3.0)
    assert conducted_heat(2.0, 1.0, 3.0, 0.5, 1.5) == -conducted_heat(2.0, 3.0, 1.0, 1.5, 0.5)


def test_matrices_of_the_steady_solvers_hold_the_slopes():
    mesh = Mesh.rectangle((4, 3), 1.3, 2.0)
    faces = Faces(mesh)
    kappa, T = np.random.default_rng(5).uniform(0.5, 2.0, (2, 12))
    assert faces.diffusion(kappa) @ T == pytest.approx(faces.diffused(kappa, T), rel=1e-12, abs=1e-13)
    assert faces.drift(T) @ kappa == pytest.approx(faces.diffused(kappa, T), rel=1e-12, abs=1e-13)


@pytest.mark.parametrize("wall", [VibratingWall(strength=0.228), ThermalWall(1.3)], ids=["vibrating", "thermal"])
def test_walls_give_what_is_conducted_to_the_last_cell(wall):
    gas, n, T, half_width = Grossman(5e4, 2e-3), 0.02, 0.9, 0.01
    flux, face = wall.face(gas, n, T, half_width, T)
    n_face = gas.density(gas.pressure(n, T), face)
    kappa = gas.conductivity(n, T), gas.conductivity(n_face, face)
    assert flux == pytest.approx(conducted_heat(1.0 / half_width, *kappa, T, face), rel=1e-7)
    in_n, in_T = wall.face_slopes(gas, n, T, half_width, face)
    h = 1e-6
    shifted = [wall.face(gas, n + i, T + j, half_width, T)[0] for i, j in ((h, 0), (-h, 0), (0, h), (0, -h))]
    assert (in_n, in_T) == pytest.approx(
        ((shifted[0] - shifted[1]) / (2 * h), (shifted[2] - shifted[3]) / (2 * h)), rel=1e-5
    )


@kernel
def conducted_then_one(T, out):
    for j in range(out.size - 1):
        out[j] = conducted_heat(1.0, 0.5, 0.5, T[j], T[j + 1])
    out[out.size - 1] = 1.0


def test_what_follows_a_loop_of_formulas_is_done():
    """Some ways of writing a function out lose the last statement of what it is written into."""
    out = np.zeros(4)
    conducted_then_one(np.arange(4.0), out)
    assert out.tolist() == [0.5, 0.5, 0.5, 1.0]
