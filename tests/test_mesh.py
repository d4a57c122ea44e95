"""The mesh."""

from __future__ import annotations

import numpy as np
import pytest

from hydro.mesh import Mesh


def test_a_stretched_mesh_fills_the_box_smoothly():
    mesh = Mesh.rectangle((64, 8), 2.0, 20.0)
    assert mesh.x_faces[0] == 0.0 and mesh.x_faces[-1] == pytest.approx(1.0, abs=1e-15)
    assert mesh.dx[-1] / mesh.dx[0] == pytest.approx(20.0 ** (63 / 64), rel=1e-12)
    assert mesh.integral(np.ones(mesh.cells)) == pytest.approx(2.0, rel=1e-14)
