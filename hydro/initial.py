"""Initial states: one builder per kind that a deck may name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import PchipInterpolator

from hydro.deck import model
from hydro.errors import Complaint, DeckError
from hydro.mesh import Mesh
from hydro.registry import Registry
from hydro.runs.checkpoint import read_checkpoint
from hydro.setup import gas_of, mesh_of
from hydro.state import State, inadmissible, worst_cell

INITIAL_STATES: Registry[Callable[[model.EvolutionDeck, Any, Mesh], State]] = Registry("initial state")
PATTERNS: Registry[Callable[[Any, Mesh], np.ndarray]] = Registry("pattern")


def initial_state(deck: model.EvolutionDeck) -> State:
    """The state that the deck starts from; DeckError where n or T would leave its bounds."""
    state = INITIAL_STATES[deck.initial.kind](deck, gas_of(deck), mesh_of(deck))
    if inadmissible(state).any():
        raise DeckError([Complaint("initial", worst_cell(state))], "initial state")
    return state


def cosine_averages(mesh: Mesh, wave: int) -> np.ndarray:
    """Cell averages of cos(pi wave y/aspect_ratio), shape (ny,)."""
    k = np.pi * wave / mesh.aspect_ratio
    return np.diff(np.sin(k * mesh.y_faces)) / (k * mesh.dy) if wave else np.ones_like(mesh.dy)


@PATTERNS.register("cosine")
def cosine(pattern: model.CosinePattern, mesh: Mesh) -> np.ndarray:
    """amplitude cos(pi wave y/aspect_ratio), shape (nx, ny)."""
    return np.broadcast_to(pattern.amplitude * cosine_averages(mesh, pattern.wave), mesh.cells)


@PATTERNS.register("modes")
def modes(pattern: model.ModesPattern, mesh: Mesh) -> np.ndarray:
    """Sum of cosines, shape (nx, ny)."""
    terms = (a * cosine_averages(mesh, wave) for a, wave in zip(pattern.amplitudes, pattern.waves, strict=True))
    return np.broadcast_to(sum(terms), mesh.cells)


@PATTERNS.register("noise")
def noise(pattern: model.NoisePattern, mesh: Mesh) -> np.ndarray:
    """Independent noise in every cell, without its mean, shape (nx, ny)."""
    field = np.random.default_rng(pattern.seed).uniform(-pattern.amplitude, pattern.amplitude, mesh.cells)
    return field - mesh.integral(field) / mesh.aspect_ratio


def patterned(deck: model.EvolutionDeck, gas, mesh: Mesh) -> State:
    """Mean density f times (1 + pattern), uniform temperature, at rest."""
    initial: Any = deck.initial
    factor = 1.0 + PATTERNS[initial.kind](initial, mesh)
    return State.of(gas, mesh, area_fraction(deck) * factor, initial.temperature)


def area_fraction(deck: model.EvolutionDeck) -> float:
    """gas.f, which the deck has checked to be there for the states that need it."""
    assert deck.gas.f is not None
    return deck.gas.f


for _name in ("cosine", "modes", "noise"):
    INITIAL_STATES.add(_name, patterned)


@INITIAL_STATES.register("uniform")
def uniform(deck: model.EvolutionDeck, gas, mesh: Mesh) -> State:
    """Uniform density, temperature and velocity."""
    initial: Any = deck.initial
    return State.of(gas, mesh, area_fraction(deck), initial.temperature, initial.velocity)


def along(axis: str, values: np.ndarray) -> np.ndarray:
    """Values along one axis, shaped to be broadcast over the mesh."""
    return values[:, None] if axis == "x" else values[None, :]


@INITIAL_STATES.register("profile")
def profile(deck: model.EvolutionDeck, gas, mesh: Mesh) -> State:
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
def riemann(deck: model.EvolutionDeck, gas, mesh: Mesh) -> State:
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
def from_checkpoint(deck: model.EvolutionDeck, gas, mesh: Mesh) -> State:
    """The state of a checkpoint, put on this mesh, with a perturbation if one is asked for."""
    initial: Any = deck.initial
    saved = read_checkpoint(Path(initial.path))
    if not np.isclose(saved.mesh.aspect_ratio, mesh.aspect_ratio, rtol=1e-12):
        problem = f"{initial.path} has the aspect ratio {saved.mesh.aspect_ratio:g}, box.aspect_ratio is another"
        raise DeckError([Complaint("initial.path", problem)], "initial state")
    state = State(gas, mesh, regrid(saved.conserved, saved.mesh, mesh))
    if initial.perturbation is None:
        return state
    return perturbed(state, PATTERNS[initial.perturbation.kind](initial.perturbation, mesh))


def perturbed(state: State, pattern: np.ndarray) -> State:
    """Density times (1 + pattern), the mass kept, at the same temperature and velocity."""
    density = state.density * (1.0 + pattern)
    density *= state.mass / state.mesh.integral(density)
    return State.of(state.gas, state.mesh, density, state.temperature, state.velocity, state.time)


def regrid(conserved: np.ndarray, old: Mesh, new: Mesh) -> np.ndarray:
    """Averages on another mesh of the same box: differences of the monotone interpolated cumulative integrals.

    Conserves each integral to round-off; an unchanged mesh gives the same bits.
    """
    for axis, (before, after) in enumerate(((old.x_faces, new.x_faces), (old.y_faces, new.y_faces)), start=1):
        if not np.array_equal(before, after):
            conserved = _regrid_axis(conserved, before, after, axis)
    return conserved


def _regrid_axis(fields: np.ndarray, before: np.ndarray, after: np.ndarray, axis: int) -> np.ndarray:
    amounts = np.moveaxis(fields, axis, 0) * np.diff(before).reshape(-1, 1, 1)
    cumulative = np.concatenate([np.zeros_like(amounts[:1]), np.cumsum(amounts, axis=0)])
    places = np.clip(after, before[0], before[-1])
    averages = np.diff(PchipInterpolator(before, cumulative)(places), axis=0) / np.diff(after).reshape(-1, 1, 1)
    return np.ascontiguousarray(np.moveaxis(averages, 0, axis))
