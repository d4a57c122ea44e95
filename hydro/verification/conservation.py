"""What the method keeps, to round-off: mass, energy less what is exchanged, symmetries, rest; and a scaling law.

Runs like the paper's Fig. 4: a vibrating wall, L = 5e4, K = 2e-3, tau = 200, area fraction 0.0235.
"""

from __future__ import annotations

import math

import numpy as np

from hydro.driver.march import march
from hydro.gas import Grossman
from hydro.mesh import Mesh
from hydro.state import State
from hydro.terms import Friction
from hydro.verification.claims import Findings, Table, at_least, at_most, measurement
from hydro.verification.setups import ELASTIC, godunov, settle
from hydro.walls import VibratingWall

TOPIC = "Conservation and symmetry"
GAS = Grossman(L=5e4, K=2e-3)
TAU, AREA_FRACTION, DELTA, W = 200.0, 0.0235, 2.0, 114.0


def cosine(mesh: Mesh) -> State:
    """A cosine of density across the box, one half-wave, with T = 1, at rest."""
    n = AREA_FRACTION * (1.0 + 0.1 * np.cos(np.pi * mesh.y / mesh.aspect_ratio))
    return State.of(GAS, mesh, n, 1.0)


def exact_sum(mesh: Mesh, field: np.ndarray) -> float:
    """Integral over the box without rounding in the sum."""
    return math.fsum((field * mesh.areas).ravel())


@measurement(TOPIC, "Mass and energy")
def ledger(full: bool) -> Findings:
    """A run of 32 x 64 cells to t = 20 from a cosine of density: drift of the mass, and of the energy's books.

    The change of energy is that given by the wall less that lost in collisions and by friction. What is missing is
    put over the largest of these and the energy at the start. Sums are formed without rounding.
    """
    mesh = Mesh.rectangle((32, 64), DELTA)
    state = cosine(mesh)
    mass, energy = exact_sum(mesh, state.density), exact_sum(mesh, state.conserved[3])
    given = march(state, godunov(mesh, GAS, VibratingWall(W), terms=[Friction(TAU)]), 20.0).ledger.amounts
    drift = abs(exact_sum(mesh, state.density) / mass - 1.0)
    change = exact_sum(mesh, state.conserved[3]) - energy
    missing = math.fsum([change, -given["wall"], given["collisions"], given["friction"]])
    residual = abs(missing) / max(map(abs, (energy, change, *given.values())))
    rows = [("start", energy), ("change", change), *given.items(), ("missing", missing)]
    return Findings(
        (
            at_most(TOPIC, "drift of the mass", "round-off", drift, 1e-12),
            at_most(TOPIC, "residual of the energy's books", "round-off", residual, 1e-10),
        ),
        (Table("Energies.", ("what", "energy"), rows),),
    )


@measurement(TOPIC, "Symmetries")
def symmetries(full: bool) -> Findings:
    """Mirrored and transposed starts give mirrored and transposed runs: largest difference of the conserved fields.

    The mirror image in y, on 32 x 32 cells with all terms and the vibrating wall; x and y exchanged, on 32 x 32
    cells of a periodic box; 1000 steps each, from a start without any symmetry.
    """
    mirrored, exchanged = mirror_difference(1000), transposed_difference(1000)
    return Findings((
        at_most(TOPIC, "y mirrored: difference after 1000 steps", "round-off", mirrored, 1e-12),
        at_most(TOPIC, "x and y exchanged: difference after 1000 steps", "round-off", exchanged, 1e-10),
    ))  # fmt: skip


def uneven(mesh: Mesh) -> State:
    """A smooth start without symmetry, at moderate speeds, periodic or not."""
    x, y = 2.0 * np.pi * mesh.x[:, None], 2.0 * np.pi * mesh.y / mesh.aspect_ratio
    n = 0.05 * (1.0 + 0.3 * np.sin(x + 0.3) * np.cos(y - 0.7) + 0.1 * np.cos(2.0 * y + 0.2 * np.sin(x)))
    T = 1.0 + 0.2 * np.cos(x - 1.0) * np.sin(y)
    return State.of(GAS, mesh, n, T, (0.1 * np.sin(x) * np.cos(y + 1.1), 0.1 * np.sin(y) * np.cos(x + 0.4)))


def mirror_difference(steps: int) -> float:
    """Between a run and the mirror image of the run that starts from the mirror image."""
    mesh = Mesh.rectangle((32, 32), DELTA)
    runs = [uneven(mesh), uneven(mesh)]
    sign = np.array([1.0, 1.0, -1.0, 1.0])[:, None, None]
    runs[1].conserved = np.ascontiguousarray(sign * runs[1].conserved[:, :, ::-1])
    march_together(runs, [godunov(mesh, GAS, VibratingWall(W), terms=[Friction(TAU)]) for _ in runs], steps)
    return float(np.max(np.abs(runs[0].conserved - sign * runs[1].conserved[:, :, ::-1])))


def transposed(state: State) -> State:
    """x and y exchanged, on a square mesh."""
    fields = state.conserved[[0, 2, 1, 3]].transpose(0, 2, 1)
    return State(state.gas, state.mesh, np.ascontiguousarray(fields), state.time)


def transposed_difference(steps: int) -> float:
    """Between a run and the transposed run that starts from the transposed state."""
    mesh = Mesh.rectangle((32, 32), periodic=(True, True))
    state = uneven(mesh)
    runs = [state, transposed(state)]
    march_together(runs, [godunov(mesh, GAS, terms=[Friction(TAU)]) for _ in runs], steps)
    return float(np.max(np.abs(runs[0].conserved - transposed(runs[1]).conserved)))


def march_together(runs: list[State], integrators: list, steps: int) -> None:
    """Advance several states by the same time steps."""
    for _ in range(steps):
        dt = integrators[0].largest_step(runs[0])
        for integrator, state in zip(integrators, runs, strict=True):
            integrator.step(state, dt)


@measurement(TOPIC, "Rest")
def rest(full: bool) -> Findings:
    """A uniform gas at rest without cooling, and layers of any density at uniform pressure without conduction.

    Largest change of the conserved fields in 200 steps, elastic walls, widths that grow threefold.
    """
    mesh = Mesh.rectangle((16, 24), DELTA, 3.0)
    n = 10.0 ** np.random.default_rng(2).uniform(-2.4, -0.1, mesh.cells)
    layers, ideal = Grossman(L=0.0, K=0.0), Grossman(L=0.0, K=2e-3)
    starts = {
        "uniform gas at rest": State.of(ideal, mesh, 0.2, 1.0),
        "layers at uniform pressure": State.of(layers, mesh, n, layers.temperature(n, 1.0)),
    }
    claims = []
    for name, state in starts.items():
        before, integrator = state.conserved.copy(), godunov(mesh, state.gas, ELASTIC, terms=[Friction(TAU)])
        march_together([state], [integrator], 200)
        change = float(np.max(np.abs(state.conserved - before)))
        claims.append(at_most(TOPIC, f"{name}: change in 200 steps", "round-off", change, 1e-12))
    return Findings(tuple(claims))


def steady_line(wall_strength: float, tolerance: float) -> State:
    """The extended state on 32 x 4 cells, from a uniform gas at T = 1, once the density stands still."""
    gas = Grossman(L=5e4, K=2e-2)
    mesh = Mesh.rectangle((32, 4), 0.25)
    state = State.of(gas, mesh, AREA_FRACTION, 1.0)
    integrator = godunov(mesh, gas, VibratingWall(wall_strength), terms=[Friction(20.0)])
    settle(integrator, state, 10.0, tolerance, 1500.0)
    return state


@measurement(TOPIC, "Strength of the driving wall")
def wall_strength(full: bool) -> Findings:
    """Steady densities do not depend on W; temperatures are proportional to it.

    The extended state on 32 x 4 cells for W = 114 and W = 28.5, from the same uniform start (T = 1, tau = 20,
    K = 0.02), so that the two runs are not scaled copies of each other; until the density changes by less than
    1e-9 in ten units of time.
    """
    weak, strong = (steady_line(strength, 1e-9) for strength in (28.5, 114.0))
    density = float(np.max(np.abs(weak.density / strong.density - 1.0)))
    temperature = float(np.max(np.abs(4.0 * weak.temperature / strong.temperature - 1.0)))
    contrast = float(strong.density.max() / strong.density.min())
    return Findings((
        at_most(TOPIC, "W = 28.5 against 114: relative difference of the densities", "0", density, 1e-6),
        at_most(TOPIC, "W = 28.5 against 114: relative difference of T/W", "0", temperature, 1e-6),
        at_least(TOPIC, "the state that is compared is not uniform: max n/min n", "well above 1", contrast, 2.0),
    ))  # fmt: skip
