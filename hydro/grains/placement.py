"""Where grains are, and how fast, at the beginning."""

from __future__ import annotations

import math

import numpy as np

from hydro.state import State

CLOSE_PACKING = 2.0 / math.sqrt(3.0)  # n_c d^2
LOOSE = 1.0 + 1e-9  # spacing of a lattice over the diameter, so that grains on it do not overlap by rounding


def number_of_grains(area_fraction: float, diameter: float, length_y: float) -> int:
    """N = f n_c L_x L_y, with n_c = 2/(3^(1/2) d^2)."""
    return round(area_fraction * CLOSE_PACKING / diameter**2 * length_y)


def lattice(diameter: float, length_y: float) -> np.ndarray:
    """The sites of the densest triangular lattice that fits into 0 < x < 1, 0 < y < length_y, periodic or not.

    Shape (sites, 2).
    """
    spacing = LOOSE * diameter
    columns = math.floor(1.0 / spacing)
    step = 1.0 / columns
    apart = max(math.sqrt(spacing**2 - 0.25 * step**2), 0.5 * spacing)  # rows: the next, and the one after it
    rows = max(math.floor(length_y / apart) // 2 * 2, 1)
    row, column = np.divmod(np.arange(rows * columns), columns)
    x = (column + 0.25 + 0.5 * (row % 2)) * step
    return np.stack([x, (row + 0.5) * (length_y / rows)], axis=1)


def too_few(number: int, diameter: float) -> str:
    """What is wrong with fewer than two grains."""
    return f"this area fraction and box hold {number} of diameter {diameter:g}; there must be two grains or more"


def placed(state: State, number: int, diameter: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities of so many grains, shape (number, 2) each, with the fields of a state.

    Sites of a lattice are taken with the probability that the density asks for. Velocities are Maxwellian about those
    of the flow; their sum and their energy are made those of the state. ValueError if there are not two grains, or not
    enough sites.
    """
    if number < 2:
        raise ValueError(too_few(number, diameter))
    random = np.random.default_rng(seed)
    mesh, sites = state.mesh, lattice(diameter, state.mesh.aspect_ratio)
    cells = cells_of(sites, mesh.x_faces, mesh.y_faces)
    share = state.density[cells]
    chosen = _chosen(np.minimum(share * (number / share.sum()), 1.0), number, random)
    positions, cells = sites[chosen], tuple(axis[chosen] for axis in cells)
    flow = np.stack([component[cells] for component in state.velocity], axis=1)
    thermal = random.standard_normal((number, 2)) * np.sqrt(state.temperature[cells])[:, None]
    thermal -= thermal.mean(axis=0)
    thermal *= math.sqrt(2.0 * state.temperature[cells].sum() / (thermal**2).sum())
    return positions, flow + thermal


def cells_of(positions: np.ndarray, x_faces: np.ndarray, y_faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Indices of the cells that hold the positions, shape (N,) each; what lies outside counts for the border."""
    faces = (x_faces, y_faces)
    i, j = (np.clip(np.searchsorted(faces[k], positions[:, k], "right") - 1, 0, faces[k].size - 2) for k in (0, 1))
    return i, j


def _chosen(share: np.ndarray, number: int, random: np.random.Generator) -> np.ndarray:
    """Indices of so many sites, each taken with the probability of its share."""
    if number > np.count_nonzero(share):
        raise ValueError(f"{number} grains do not fit: the densest lattice has {share.size} sites")
    taken = random.random(share.size) < share
    surplus = int(taken.sum()) - number
    if surplus == 0:
        return np.flatnonzero(taken)
    pool = np.flatnonzero(taken if surplus > 0 else ~taken & (share > 0.0))
    weights = 1.0 - share[pool] if surplus > 0 else share[pool]
    weights = weights + 1e-12
    taken[random.choice(pool, abs(surplus), replace=False, p=weights / weights.sum())] ^= True
    return np.flatnonzero(taken)
