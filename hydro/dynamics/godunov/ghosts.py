"""The rows of cells beyond the sides of the box, which the flow solver looks at as at any others."""

from __future__ import annotations

import numpy as np

from hydro.dynamics.godunov.hancock import primitive
from hydro.fields import MX, MY, E, N, P, U, V
from hydro.jit import kernel, part
from hydro.mesh import GHOSTS
from hydro.walls.boundary import HIGH, LOW, reflect


@kernel
def fill_ghosts(gas, laws, periodic, state, sides):
    """Fill the ghost rows of all sides, corners included, for the conserved `state` (4, nx, ny).

    laws: of what lies beyond the sides x0, x1, y0 and y1. periodic: in x and in y. This alone is compiled for the laws
    that are there, as a set: it calls the kernel of each.
    """
    image_x(gas, periodic[0], state, sides.ghost_x)
    if not periodic[0]:
        reflect(laws[0], 0, sides.ghost_x[LOW])
        reflect(laws[1], 0, sides.ghost_x[HIGH])
    image_y(gas, periodic[1], state, sides.ghost_x, sides.ghost_y)
    if not periodic[1]:
        reflect(laws[2], 1, sides.ghost_y[LOW])
        reflect(laws[3], 1, sides.ghost_y[HIGH])


@kernel
def image_x(gas, periodic, state, ghosts):
    """Images of the rows beside the sides in x; beyond a periodic side, the rows at the other end."""
    nx = state.shape[1]
    for ghost in range(GHOSTS):
        low, high = ((nx - 1 - ghost) % nx, ghost % nx) if periodic else (ghost, nx - 1 - ghost)
        image_row(gas, state, low, ghosts[LOW, ghost])
        image_row(gas, state, high, ghosts[HIGH, ghost])


@part
def image_row(gas, state, i, out):
    """Primitive fields of row i."""
    density, momentum_x, momentum_y, energy = state[N, i], state[MX, i], state[MY, i], state[E, i]
    for j in range(np.uint64(density.size)):
        n, u, v, p = primitive(gas, density[j], momentum_x[j], momentum_y[j], energy[j])
        out[N, j], out[U, j], out[V, j], out[P, j] = n, u, v, p


@kernel
def image_y(gas, periodic, state, ghost_x, ghosts):
    """The same in y, of columns that begin and end with the ghost rows in x."""
    ny = state.shape[2]
    for ghost in range(GHOSTS):
        low, high = ((ny - 1 - ghost) % ny, ghost % ny) if periodic else (ghost, ny - 1 - ghost)
        image_column(gas, state, ghost_x, low, ghosts[LOW, ghost])
        image_column(gas, state, ghost_x, high, ghosts[HIGH, ghost])


@part
def image_column(gas, state, ghost_x, j, out):
    """Primitive fields of column j, (4, nx + 2 GHOSTS)."""
    nx = state.shape[1]
    for i in range(nx):
        n, u, v, p = primitive(gas, state[N, i, j], state[MX, i, j], state[MY, i, j], state[E, i, j])
        k = i + GHOSTS
        out[N, k], out[U, k], out[V, k], out[P, k] = n, u, v, p
    for ghost in range(GHOSTS):
        for q in range(4):
            out[q, GHOSTS - 1 - ghost] = ghost_x[LOW, ghost, q, j]
            out[q, nx + GHOSTS + ghost] = ghost_x[HIGH, ghost, q, j]
