"""What solvers ask of a wall."""

from __future__ import annotations

from typing import Protocol


class WallLaw(Protocol):
    """The heat that a wall gives; a NamedTuple of its constants.

    All arguments are numbers: density n and temperature T of the cell beside it, the distance from its centre to the
    wall. A law may also have `beyond(n, normal, tangential, p)`, which turns the image of a cell into what lies beyond
    the wall, as in `hydro.walls.elastic`; without it the wall is smooth. Without `face` it gives no heat.
    """

    def face(self, gas, n, T, half_width, guess):
        """(heat flux into the gas, wall temperature); `guess` is a wall temperature to start from."""

    def face_slopes(self, gas, n, T, half_width, wall):
        """(d flux/dn, d flux/dT) of the last cell, for the wall temperature that `face` found there."""
