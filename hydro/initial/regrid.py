"""A state on another mesh of the same box."""

from __future__ import annotations

import numpy as np

from hydro.mesh import Mesh
from hydro.state import State


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
