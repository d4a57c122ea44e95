"""What solvers ask of a driving wall."""

from __future__ import annotations

from typing import Protocol


class WallLaw(Protocol):
    """The heat that a wall at x = 1 gives; a NamedTuple of its constants.

    All arguments are numbers: density n and temperature T of the last cell, the distance from its centre to the wall.
    """

    def face(self, gas, n, T, half_width, guess):
        """(heat flux into the gas, wall temperature); `guess` is a wall temperature to start from."""

    def face_slopes(self, gas, n, T, half_width, wall):
        """(d flux/dn, d flux/dT) of the last cell, for the wall temperature that `face` found there."""
