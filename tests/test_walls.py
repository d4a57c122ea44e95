"""The laws of driving walls."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from hydro.driver.march import march
from hydro.driver.trackers import EachStep
from hydro.dynamics import Godunov
from hydro.gas import Grossman
from hydro.mesh import Mesh
from hydro.state import State
from hydro.walls import ThermalWall, VibratingWall

SCRIPT = """
from typing import NamedTuple
from hydro.dynamics import Godunov
from hydro.gas import Grossman
from hydro.methods import compiled_methods
from hydro.mesh import Mesh
from hydro.state import State

@compiled_methods
class GivenFlux(NamedTuple):
    flux: float

    def face(self, gas, n, T, half_width, guess):
        return self.flux, T

gas, mesh = Grossman(0.0, 1e-3), Mesh.rectangle((8, 8))
state = State.of(gas, mesh, 0.1, 1.0)
print(Godunov(gas, GivenFlux(0.25), mesh).step(state, 1e-3)["wall"])
"""


def test_a_wall_written_in_a_script_runs_and_disturbs_nobody(tmp_path):
    script = tmp_path / "my_wall.py"
    script.write_text(SCRIPT)
    printed = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True).stdout
    assert float(printed) == pytest.approx(0.25e-3, rel=1e-13)
    gas, mesh = Grossman(0.0, 1e-3), Mesh.rectangle((8, 8))
    fresh = (
        "from hydro.dynamics import *; from hydro.gas import *; from hydro.mesh import *; from hydro.state import *\n"
        "from hydro.walls import *\n"
        "gas, mesh = Grossman(0.0, 1e-3), Mesh.rectangle((8, 8))\n"
        "print(Godunov(gas, VibratingWall(strength=1e-3), mesh).step(State.of(gas, mesh, 0.1, 1.0), 1e-3)['wall'])"
    )
    other = subprocess.run([sys.executable, "-c", fresh], capture_output=True, text=True, check=True).stdout
    wall, state = VibratingWall(strength=1e-3), State.of(gas, mesh, 0.1, 1.0)
    assert float(other) == Godunov(gas, wall, mesh).step(state, 1e-3)["wall"]


@pytest.mark.parametrize(
    ("cold", "K", "L"), [(1e-2, 2e-3, 5e4), (1e-4, 2e-3, 5e4), (1e-6, 2e-3, 5e4), (1e-3, 0.2, 5e4)]
)
def test_cold_gas_beside_a_hot_wall_loses_heat_and_does_not_overshoot(cold, K, L):
    gas, mesh = Grossman(L, K), Mesh.rectangle((32, 8))
    state = State.of(gas, mesh, 0.0235, cold)
    losses, hottest = [], []

    def watch(run):
        losses.append(run.ledger.amounts["collisions"])
        hottest.append(run.state.temperature.max())

    march(state, Godunov(gas, ThermalWall(1.0), mesh), 0.5, [EachStep(watch)])
    assert np.all(np.diff(losses) > 0.0)
    assert max(hottest) < 1.0


@pytest.mark.parametrize(("n", "T", "W"), [(0.004, 1.0, 114.0), (0.6, 1e-5, 114.0), (0.99, 1e-3, 1e4), (0.3, 1.0, 0.0)])
def test_the_vibrating_wall_balances_heat_also_against_cold_dense_gas(n, T, W):
    """A strong wall against dense gas: the heat given first grows with the wall's temperature."""
    gas, half_width = Grossman(1e6, 0.1), 1.0 / 32.0
    flux, wall = VibratingWall(strength=gas.K * W).face(gas, n, T, half_width, T)
    face = gas.density(gas.pressure(n, T), wall)
    conducted = 0.5 * (gas.conductivity(n, T) + gas.conductivity(face, wall)) * (wall - T) / half_width
    assert wall >= T and face <= n
    assert flux == pytest.approx(gas.K * W * face * np.sqrt(wall), rel=1e-12, abs=1e-300)
    assert conducted == pytest.approx(flux, rel=1e-7, abs=1e-12)
