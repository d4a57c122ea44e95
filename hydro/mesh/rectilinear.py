"""The rectilinear mesh of the box 0 < x < 1, 0 < y < aspect ratio."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

ROUND_OFF = 4  # of a width, in units of that of the last face
GHOSTS = 2  # cells beyond each side that the flow solver looks at


@dataclass(frozen=True, eq=False)
class Mesh:
    """Cells of a rectilinear mesh. Lengths in L_x; arrays over cells have shape (nx, ny), index [i, j] ~ (x, y).

    x_faces, y_faces: increasing, shapes (nx+1,) and (ny+1,). periodic: whether x and y are periodic.
    """

    x_faces: np.ndarray
    y_faces: np.ndarray
    periodic: tuple[bool, bool] = (False, False)

    @classmethod
    def rectangle(
        cls,
        cells: tuple[int, int],
        aspect_ratio: float = 1.0,
        stretch: float = 1.0,
        periodic: tuple[bool, bool] = (False, False),
    ) -> Mesh:
        """A box of nx x ny cells, uniform in y; widths in x grow geometrically by `stretch` from x=0 to x=1."""
        nx, ny = cells
        even = np.linspace(0.0, 1.0, nx + 1)
        faces = even if stretch == 1.0 else np.expm1(even * np.log(stretch)) / (stretch - 1.0)
        return cls(faces, aspect_ratio * np.linspace(0.0, 1.0, ny + 1), periodic)

    @property
    def cells(self) -> tuple[int, int]:
        return self.x_faces.size - 1, self.y_faces.size - 1

    @property
    def aspect_ratio(self) -> float:
        return float(self.y_faces[-1])

    @cached_property
    def dx(self) -> np.ndarray:
        """Widths in x, shape (nx,)."""
        return widths(self.x_faces)

    @cached_property
    def dy(self) -> np.ndarray:
        """Widths in y, shape (ny,)."""
        return widths(self.y_faces)

    @cached_property
    def x(self) -> np.ndarray:
        """Cell centres in x, shape (nx,)."""
        return 0.5 * (self.x_faces[1:] + self.x_faces[:-1])

    @cached_property
    def y(self) -> np.ndarray:
        """Cell centres in y, shape (ny,)."""
        return 0.5 * (self.y_faces[1:] + self.y_faces[:-1])

    @cached_property
    def areas(self) -> np.ndarray:
        """Cell areas, shape (nx, ny)."""
        return self.dx[:, None] * self.dy[None, :]

    def integral(self, field: np.ndarray) -> float:
        """Integral over the box of a field given by its cell averages, shape (nx, ny)."""
        return float(self.dx @ field @ self.dy)

    def spacing(self, axis: int) -> np.ndarray:
        """Per cell, ghosts included: its width h, and h over the distance to the centre below and above.

        Shape (3, count + 2 GHOSTS). Multiplied with these ratios, one-sided differences become differences
        over one cell width.
        """
        h = np.pad((self.dx, self.dy)[axis], GHOSTS, mode="wrap" if self.periodic[axis] else "symmetric")
        between = 0.5 * (h[1:] + h[:-1])
        padded = np.concatenate([h[:1], between, h[-1:]])
        return np.array([h, h / padded[:-1], h / padded[1:]])


def widths(faces: np.ndarray) -> np.ndarray:
    """Distances between faces; the very same for all if they differ by round-off: mirror images are exact then."""
    between = np.diff(faces)
    mean = (faces[-1] - faces[0]) / between.size
    even = np.abs(between - mean).max() <= ROUND_OFF * np.spacing(np.abs(faces).max())
    return np.full_like(between, mean) if even else between
