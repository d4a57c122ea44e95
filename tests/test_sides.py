"""Laws on every side: a wall heats the gas the same way wherever it stands, and its heat is in the books."""

from __future__ import annotations

import numpy as np
import pytest

from hydro.driver.march import Run, advance
from hydro.dynamics import Godunov, LagrangeRemap
from hydro.gas import Grossman
from hydro.mesh import Mesh
from hydro.state import State
from hydro.terms import Friction, Viscosity
from hydro.walls import ThermalWall, VibratingWall, Walls

GAS = Grossman(L=1e4, K=5e-3)
LAWS = {"thermal": ThermalWall(1.5), "vibrating": VibratingWall(strength=0.3)}
END = 0.3


def ripple(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A density and a temperature without any symmetry, in a box of unit sides."""
    n = 0.1 * (1.0 + 0.3 * np.cos(np.pi * x) + 0.2 * np.cos(2.0 * np.pi * y))
    return n, 1.0 + 0.2 * np.cos(np.pi * x) * np.cos(np.pi * y) + 0.0 * x


def run_on(method, side: str, law) -> Run:
    """The gas before a wall on a side; seen from the wall, it is the same gas whichever side that is."""
    cells = (10, 16) if side[0] == "x" else (16, 10)
    mesh = Mesh(np.linspace(0.0, 1.0, cells[0] + 1), np.linspace(0.0, 1.0, cells[1] + 1))
    from_wall, along = mesh.x[:, None], mesh.y[None, :]
    if side[0] == "y":
        from_wall, along = along, from_wall
    n, T = ripple(1.0 - from_wall if side[1] == "1" else from_wall, along)
    state = State.of(GAS, mesh, n, T)
    run = Run(state, method(GAS, Walls(**{side: law}), mesh, [Friction(5.0), Viscosity(0.5)]), END)
    while state.time < run.end:
        advance(run, run.end)
    return run


def turned(state: State, side: str) -> np.ndarray:
    """Density and temperature with the wall at the low end of the first axis."""
    fields = np.array([state.density, state.temperature])
    fields = fields if side[0] == "x" else fields.swapaxes(1, 2)
    return fields[:, ::-1] if side[1] == "1" else fields


@pytest.mark.parametrize("method", [Godunov, LagrangeRemap])
@pytest.mark.parametrize("law", LAWS)
def test_a_wall_heats_the_same_from_every_side(method, law):
    runs = {side: run_on(method, side, LAWS[law]) for side in ("x0", "x1", "y0", "y1")}
    reference = turned(runs["x1"].state, "x1")
    books = runs["x1"].ledger.balance(runs["x1"].state.energy)
    assert abs(books["wall"]) > 1e-3 and abs(books["residual"]) < 1e-12
    for side, run in runs.items():
        assert turned(run.state, side) == pytest.approx(reference, rel=1e-8), side
        assert run.ledger.balance(run.state.energy)["wall"] == pytest.approx(books["wall"], rel=1e-8)


@pytest.mark.parametrize("method", [Godunov, LagrangeRemap])
def test_heat_from_four_walls_adds_up(method):
    """All sides at once, with different laws: the books close, and the gas beside the hottest wall is hottest."""
    mesh = Mesh.rectangle((12, 12), stretch=3.0)
    state = State.of(GAS, mesh, 0.1, 1.0)
    walls = Walls(x0=ThermalWall(0.5), x1=VibratingWall(strength=0.3), y0=ThermalWall(3.0), y1=ThermalWall(1.0))
    run = Run(state, method(GAS, walls, mesh), END)
    while state.time < run.end:
        advance(run, run.end)
    assert abs(run.ledger.balance(state.energy)["residual"]) < 1e-12
    beside = {"x0": state.temperature[0], "y0": state.temperature[:, 0], "y1": state.temperature[:, -1]}
    middle = {side: values[4:-4].mean() for side, values in beside.items()}
    assert middle["x0"] < middle["y1"] < middle["y0"]


@pytest.mark.parametrize("method", [Godunov, LagrangeRemap])
def test_what_four_walls_know_is_remembered(method):
    """Two steps in one go are two steps with a pause in between, to the last bit."""
    mesh, walls = Mesh.rectangle((8, 8)), Walls(ThermalWall(0.5), ThermalWall(1.5), ThermalWall(2.0), ThermalWall(1.0))
    state = State.of(GAS, mesh, 0.1, 1.0)
    integrator = method(GAS, walls, mesh)
    integrator.step(state, 1e-3)
    paused, memory = state.copy(), integrator.memory()
    integrator.step(state, 1e-3)
    again = method(GAS, walls, mesh)
    again.remember(memory)
    again.step(paused, 1e-3)
    assert np.array_equal(state.conserved, paused.conserved)
