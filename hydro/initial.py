"""Initial states: one builder per kind that a deck may name."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from hydro.deck.evolution import RunDeck
from hydro.deck.initial import CosinePattern, ModesPattern, NoisePattern
from hydro.errors import CheckpointError, Complaint, DeckError
from hydro.exact.evolution import EVOLUTIONS, exact_evolution
from hydro.mesh import Mesh
from hydro.output.checkpoint import Checkpoint, averaged, read_checkpoint
from hydro.registry import Registry
from hydro.setup import gas_of, mesh_of
from hydro.state import State, inadmissible, worst_cell

INITIAL_STATES: Registry[Callable[[RunDeck, Any, Mesh], State]] = Registry("initial state")
PATTERNS: Registry[Callable[[Any, Mesh], np.ndarray]] = Registry("pattern")


def initial_state(deck: RunDeck) -> State:
    """The state that the deck starts from; DeckError where n or T would leave its bounds."""
    state = INITIAL_STATES[deck.initial.kind](deck, gas_of(deck), mesh_of(deck))
    if inadmissible(state).any():
        raise DeckError([Complaint("initial", worst_cell(state))], "initial state")
    return state


def cosine_averages(mesh: Mesh, wave: int) -> np.ndarray:
    """Cell averages of cos(pi wave y/aspect_ratio), shape (ny,): even or odd about the middle, to the last bit."""
    if wave == 0:
        return np.ones_like(mesh.dy)
    k = np.pi * wave / mesh.aspect_ratio
    averages = np.diff(np.sin(k * mesh.y_faces)) / (k * mesh.dy)
    return 0.5 * (averages + (-1.0) ** wave * averages[::-1])


@PATTERNS.register("cosine")
def cosine(pattern: CosinePattern, mesh: Mesh) -> np.ndarray:
    """amplitude cos(pi wave y/aspect_ratio), shape (nx, ny)."""
    return np.broadcast_to(pattern.amplitude * cosine_averages(mesh, pattern.wave), mesh.cells)


@PATTERNS.register("modes")
def modes(pattern: ModesPattern, mesh: Mesh) -> np.ndarray:
    """Sum of cosines, shape (nx, ny)."""
    terms = (a * cosine_averages(mesh, wave) for a, wave in zip(pattern.amplitudes, pattern.waves, strict=True))
    return np.broadcast_to(sum(terms), mesh.cells)


@PATTERNS.register("noise")
def noise(pattern: NoisePattern, mesh: Mesh) -> np.ndarray:
    """Independent noise in every cell, without its mean, shape (nx, ny)."""
    field = np.random.default_rng(pattern.seed).uniform(-pattern.amplitude, pattern.amplitude, mesh.cells)
    return field - mesh.integral(field) / mesh.aspect_ratio


def patterned(deck: RunDeck, gas, mesh: Mesh) -> State:
    """Mean density f times (1 + pattern), uniform temperature, at rest."""
    initial: Any = deck.initial
    factor = 1.0 + PATTERNS[initial.kind](initial, mesh)
    return State.of(gas, mesh, area_fraction(deck) * factor, initial.temperature)


def area_fraction(deck: RunDeck) -> float:
    """gas.f, which the deck has checked to be there for the states that need it."""
    assert deck.gas.f is not None
    return deck.gas.f


for _name in ("cosine", "modes", "noise"):
    INITIAL_STATES.add(_name, patterned)


def start_of_exact(deck: RunDeck, gas, mesh: Mesh) -> State:
    """The state from which an exact evolution starts."""
    return State(gas, mesh, exact_evolution(deck)(mesh, 0.0))


for _name in EVOLUTIONS:
    INITIAL_STATES.add(_name, start_of_exact)


def along(axis: str, values: np.ndarray) -> np.ndarray:
    """Values along one axis, shaped to be broadcast over the mesh."""
    return values[:, None] if axis == "x" else values[None, :]


@INITIAL_STATES.register("profile")
def profile(deck: RunDeck, gas, mesh: Mesh) -> State:
    """Piecewise linear profiles, taken at cell centres."""
    initial: Any = deck.initial
    centres = mesh.x if initial.axis == "x" else mesh.y

    def field(values):
        return np.interp(centres, initial.positions, values or np.zeros(len(initial.positions)))

    density = field(initial.density)
    T = field(initial.temperature) if initial.temperature else gas.temperature(density, field(initial.pressure))
    velocity = [along(initial.axis, field(values)) for values in (initial.velocity, initial.transverse_velocity)]
    components = velocity if initial.axis == "x" else velocity[::-1]
    return State.of(gas, mesh, along(initial.axis, density), along(initial.axis, T), tuple(components))


@INITIAL_STATES.register("riemann")
def riemann(deck: RunDeck, gas, mesh: Mesh) -> State:
    """Two uniform states; the cell that the jump crosses gets the average of their conserved quantities."""
    initial: Any = deck.initial
    faces = mesh.x_faces if initial.axis == "x" else mesh.y_faces
    share = np.clip((initial.position * faces[-1] - faces[:-1]) / np.diff(faces), 0.0, 1.0)
    left, right = (_conserved_along(gas, mesh, initial.axis, side) for side in (initial.left, initial.right))
    return State(gas, mesh, right + (left - right) * along(initial.axis, share))


def _conserved_along(gas, mesh: Mesh, axis: str, primitive) -> np.ndarray:
    n, speed, p = primitive
    velocity = (speed, 0.0) if axis == "x" else (0.0, speed)
    return State.of(gas, mesh, n, gas.temperature(n, p), velocity).conserved


@INITIAL_STATES.register("checkpoint")
def from_checkpoint(deck: RunDeck, gas, mesh: Mesh) -> State:
    """The state of a checkpoint, of grains the average over their looks, on this mesh, with a perturbation or none."""
    initial: Any = deck.initial
    saved = checkpoint_of(deck)
    state = regrid(State(gas, saved.mesh, averaged(saved)), mesh)
    if initial.refill and not inadmissible(state).any():  # else it is refused, for what it is
        state = refilled(state, area_fraction(deck))
    if initial.perturbation is None:
        return state
    return perturbed(state, PATTERNS[initial.perturbation.kind](initial.perturbation, mesh))


def checkpoint_of(deck: RunDeck) -> Checkpoint:
    """The checkpoint that a deck starts from; DeckError if it cannot be read, or is of another box."""
    initial: Any = deck.initial
    try:
        saved = read_checkpoint(Path(initial.path))
    except CheckpointError as error:
        raise DeckError([Complaint("initial.path", str(error))], "initial state") from error
    if not np.isclose(saved.mesh.aspect_ratio, deck.box.aspect_ratio, rtol=1e-12):
        problem = f"{initial.path} has the aspect ratio {saved.mesh.aspect_ratio:g}, box.aspect_ratio is another"
        raise DeckError([Complaint("initial.path", problem)], "initial state")
    return saved


def refilled(state: State, mean: float) -> State:
    """The state with the mean density `mean`: n/(1-n/n_p) times a common factor, at the same temperature and velocity.

    No density comes to that of packing, n_p. The pressure, like n/(1-n/n_p) in dilute and in dense gas, changes by
    about that factor.
    """
    from scipy.optimize import brentq  # slow to import

    gas, mesh = state.gas, state.mesh
    odds, wanted = (n / gas.gap(n) for n in (state.density, mean))

    def filled(log_factor: float) -> np.ndarray:
        changed = odds * math.exp(log_factor)
        return changed / (1.0 + changed / gas.packing_density())

    def excess(log_factor: float) -> float:
        return mesh.integral(filled(log_factor)) - mean * mesh.aspect_ratio

    bounds = (math.log(wanted / odds.max()), math.log(wanted / odds.min()))  # where n is below, and above, everywhere
    density = filled(brentq(excess, bounds[0] - 1e-9, bounds[1] + 1e-9, xtol=1e-14))
    return State.of(gas, mesh, density, state.temperature, state.velocity, state.time)


def perturbed(state: State, pattern: np.ndarray) -> State:
    """Density times (1 + pattern), the mass kept, at the same temperature and velocity."""
    density = state.density * (1.0 + pattern)
    density *= state.mass / state.mesh.integral(density)
    return State.of(state.gas, state.mesh, density, state.temperature, state.velocity, state.time)


def regrid(state: State, mesh: Mesh) -> State:
    """The state on another mesh of the same box; mass, momenta and energy are kept to round-off.

    Density and momenta are averages of their limited linear reconstructions, hence bounded by neighbours; so is
    pressure, from which the temperature follows: where pressure is uniform it stays so, which averages of the
    energy would not give. What that does to the energy, a common factor on the temperature undoes.
    """
    old = state.mesh
    if np.array_equal(old.x_faces, mesh.x_faces) and np.array_equal(old.y_faces, mesh.y_faces):
        return State(state.gas, mesh, state.conserved.copy(), state.time)
    fields = np.array([*state.conserved[:3], state.pressure])
    along_x = _averages(fields, old.x_faces, mesh.x_faces, 1)
    n, momentum_x, momentum_y, p = _averages(along_x, old.y_faces, mesh.y_faces, 2)
    moved = State.of(state.gas, mesh, n, state.gas.temperature(n, p), (momentum_x / n, momentum_y / n), state.time)
    kinetic = mesh.integral(moved.kinetic_energy)
    factor = (state.energy - kinetic) / (moved.energy - kinetic)
    return State.of(state.gas, mesh, n, factor * moved.temperature, moved.velocity, state.time)


def _averages(fields: np.ndarray, before: np.ndarray, after: np.ndarray, axis: int) -> np.ndarray:
    """Averages over cells with the faces `after` of limited linear profiles in cells with the faces `before`."""
    lines = np.moveaxis(fields, axis, 0)
    widths, centres = np.diff(before), 0.5 * (before[1:] + before[:-1])
    slopes = np.zeros_like(lines)
    steps = np.diff(lines, axis=0) / np.diff(centres)[:, None, None]
    gentler = np.where(np.abs(steps[1:]) < np.abs(steps[:-1]), steps[1:], steps[:-1])
    slopes[1:-1] = np.where(steps[1:] * steps[:-1] > 0.0, gentler, 0.0)
    full = np.concatenate([np.zeros_like(lines[:1]), np.cumsum(lines * widths[:, None, None], axis=0)])
    places = np.clip(after, before[0], before[-1])
    cell = np.clip(np.searchsorted(before, places, side="right") - 1, 0, widths.size - 1)
    into = (places - before[cell])[:, None, None]
    cumulative = full[cell] + into * (lines[cell] + 0.5 * slopes[cell] * (into - widths[cell][:, None, None]))
    return np.moveaxis(np.diff(cumulative, axis=0) / np.diff(after)[:, None, None], 0, axis)
