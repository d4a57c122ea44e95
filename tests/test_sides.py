"""Laws on every side: a wall heats the gas the same way wherever it stands, and its heat is in the books."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

from hydro.driver.march import Run, advance
from hydro.dynamics import Godunov, LagrangeRemap
from hydro.dynamics.godunov import hancock, heat
from hydro.dynamics.lagrange import balance, completion, jacobian
from hydro.errors import StepRejected
from hydro.gas import Grossman
from hydro.mesh import Mesh
from hydro.methods import compiled_methods
from hydro.state import State
from hydro.terms import Friction, Viscosity
from hydro.walls import ElasticWall, ThermalWall, VibratingWall, Walls
from hydro.walls.boundary import FLOW, STRESS

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


@pytest.mark.parametrize("side", ["x0", "x1", "y0", "y1"])
def test_what_flows_through_a_side_is_in_the_gas_and_in_the_books(side):
    """By the implicit integrator, which reads the flow of the sides; the gas beside the side comes in."""
    mesh = Mesh.rectangle((8, 8))
    state = State.of(Grossman(0.0, 0.0), mesh, 0.1, 1.0)
    integrator = LagrangeRemap(state.gas, ElasticWall(), mesh)
    rows = {"x": integrator.boundary.sides.x, "y": integrator.boundary.sides.y}[side[0]]
    rows[int(side[1]), FLOW, :-1] = 0.01 if side[1] == "0" else -0.01
    run, before = Run(state, integrator, 0.2), state.energy
    while state.time < run.end:
        advance(run, run.end)
    assert state.mass == pytest.approx(0.1 + 0.2 * 0.01, rel=1e-12)
    books = run.ledger.balance(state.energy)
    assert books["wall"] == pytest.approx(state.energy - before, rel=1e-10) and books["wall"] > 0.2 * 0.01


@pytest.mark.parametrize("method", [Godunov, LagrangeRemap])
def test_shear_stress_of_a_wall_stops_the_gas_and_heats_it(method):
    """A wall at rest does no work: energy stays, and the gas gets the momentum that its stress gives."""
    mesh = Mesh.rectangle((8, 12), periodic=(False, True))
    state = State.of(Grossman(0.0, 5e-3), mesh, 0.1, 1.0, (0.0, 0.2))
    integrator = method(state.gas, ElasticWall(), mesh, [Viscosity(1.0)])
    integrator.boundary.sides.x[1, STRESS, 1:-1] = -0.02
    run, before = Run(state, integrator, 0.1), state.energy
    while state.time < run.end:
        advance(run, run.end)
    momentum = mesh.integral(state.conserved[2])
    assert momentum == pytest.approx(0.1 * 0.2 - 0.02 * 0.1 * 11.0 / 12.0, rel=0.02)
    assert state.energy == pytest.approx(before, rel=1e-12)


def test_sweeps_are_compiled_once_whatever_the_laws_are():
    """Another law costs kernels of its own, another set of laws nothing."""
    sweeps = [
        hancock.advance,
        heat.start_rates,
        heat.stage,
        balance.balance,
        jacobian.find_jacobian,
        completion.complete,
    ]
    mesh, laws = Mesh.rectangle((8, 8)), [ThermalWall(1.5), VibratingWall(strength=0.3), ElasticWall()]
    compiled = []
    for x0, x1 in [(laws[2], laws[2]), (laws[0], laws[2]), (laws[1], laws[0]), (laws[0], laws[1])]:
        for method in (Godunov, LagrangeRemap):
            state = State.of(GAS, mesh, 0.1, 1.0)
            method(GAS, Walls(x0=x0, x1=x1), mesh).step(state, 1e-4)
        compiled.append([len(sweep.signatures) for sweep in sweeps])
    assert compiled == [compiled[0]] * 4


@compiled_methods
class Insatiable(NamedTuple):
    """A law that finds no heat for cold gas."""

    least: float

    def face(self, gas, n, T, half_width, guess):
        return (0.0 if self.least < T else np.nan), T

    def face_slopes(self, gas, n, T, half_width, wall):
        return 0.0, 0.0


@pytest.mark.parametrize("method", [Godunov, LagrangeRemap])
def test_a_law_without_a_solution_is_named(method):
    mesh = Mesh.rectangle((8, 8))
    state = State.of(GAS, mesh, 0.1, 1.0)
    with pytest.raises(StepRejected, match=r"the law of the wall y0 finds no heat for n = 0\.1, T = "):
        method(GAS, Walls(y0=Insatiable(2.0)), mesh).step(state, 1e-4)


def test_laws_that_make_no_sense_are_refused():
    with pytest.raises(TypeError, match=r"the wall y0 is the class ThermalWall; give a law, ThermalWall\(...\)"):
        Walls.of(Walls(y0=ThermalWall))
    with pytest.raises(ValueError, match=r"strength = -0.1: a vibrating wall gives heat"):
        VibratingWall(strength=-0.1)
