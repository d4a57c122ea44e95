"""Differences between cells and the places between them, as sparse matrices: for flow linearized about a steady state.

Velocities stand on the faces that they point through, shear in the corners, as in `hydro.terms.viscosity.stress`. A
perturbation of one symmetry needs only a part of the box: on a mirror about which it is odd the velocity across does
not vanish, and a wave in y needs one cell in y and one place, where its sine stands.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse


@dataclass(frozen=True, eq=False)
class Between:
    """The places between the cells of one direction where the velocity along it does not vanish.

    widths: (cells,). distances: (places,), lengths that belong to the places. stretch: (cells, places), slope in cells
    of what stands in the places. mean: (places, cells), values there of what is even about mirrors. back: (cells,
    places), values in cells of what stands in the places.
    """

    widths: np.ndarray
    distances: np.ndarray
    stretch: sparse.csr_array
    mean: sparse.csr_array
    back: sparse.csr_array

    @classmethod
    def cells(cls, widths: np.ndarray, mirrors: tuple[int, ...] = ()) -> Between:
        """Between cells of these widths, and on the mirrors beside the cells of these numbers, 0 or -1."""
        count = widths.size
        below = [*range(count - 1), *(count - 1 if side else None for side in mirrors)]
        above = [*range(1, count), *(None if side else 0 for side in mirrors)]
        shape = (count, len(below))
        stretch, sides = np.zeros(shape), np.zeros(shape)
        for place, (low, high) in enumerate(zip(below, above, strict=True)):
            for cell, sign in ((low, 1.0), (high, -1.0)):
                if cell is not None:
                    stretch[cell, place], sides[cell, place] = sign / widths[cell], 1.0
        distances = 0.5 * (widths @ sides)
        return cls(
            widths, distances, sparse.csr_array(stretch), sparse.csr_array((sides / sides.sum(axis=0)).T),
            sparse.csr_array(0.5 * sides),
        )  # fmt: skip

    @classmethod
    def wave(cls, widths: np.ndarray, slope: float, back: float) -> Between:
        """One cell, (1,), of a wave: its differences are `slope`, its means over two `back` times its values."""
        one = sparse.csr_array(np.ones((1, 1)))
        return cls(widths, widths, one * slope, one, one * back)

    @cached_property
    def slope(self) -> sparse.csr_array:
        """(places, cells), slope in the places of what stands in cells."""
        return -sparse.diags_array(1.0 / self.distances) @ self.stretch.T @ sparse.diags_array(self.widths)


class Staggered:
    """Slopes and means in both directions; cells are numbered as in a raveled (nx, ny) array, places likewise."""

    def __init__(self, x: Between, y: Between):
        cells_x, cells_y = (sparse.eye_array(each.widths.size) for each in (x, y))
        places_x, places_y = (sparse.eye_array(each.distances.size) for each in (x, y))
        # from places to cells and back
        self.stretch = (product(x.stretch, cells_y), product(cells_x, y.stretch))
        self.slope = (product(x.slope, cells_y), product(cells_x, y.slope))
        self.mean = (product(x.mean, cells_y), product(cells_x, y.mean))
        self.back = (product(x.back, cells_y), product(cells_x, y.back))
        # to corners: of u in y, of v in x, and of what stands in cells
        self.shear = (product(places_x, y.slope), product(x.slope, places_y))
        self.corner = product(x.mean, y.mean)
        self.areas = np.outer(x.widths, y.widths).ravel()
        self.face_areas = (np.outer(x.distances, y.widths).ravel(), np.outer(x.widths, y.distances).ravel())
        self.corner_areas = np.outer(x.distances, y.distances).ravel()


def product(in_x: sparse.csr_array, in_y: sparse.csr_array) -> sparse.csr_array:
    """The matrix that acts on both indices of a field."""
    return sparse.csr_array(sparse.kron(in_x, in_y, format="csr"))
