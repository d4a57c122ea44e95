"""The vibrating wall, Eq. (wall1)."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

import numpy as np
from pydantic import Field

from hydro.gas.conduction import face_conductivity
from hydro.methods import compiled_methods
from hydro.schema import NonNegative, TaggedLaw
from hydro.walls.heated import HeatedFace

ITERATIONS = 50
TOLERANCE = 1e-8  # of the last of Newton's changes: the error left is of the order of its square


class VibratingWallConstants(NamedTuple):
    """strength 0 is an elastic wall."""

    strength: float  # (2/pi)^(1/2) A^2 omega^2/T_*, which decks call K W


@compiled_methods
class VibratingWall(VibratingWallConstants, HeatedFace):
    """kappa dT/dx = strength n T^(1/2), Eq. (wall1) with q = (2/pi)^(1/2) A^2 omega^2 n T^(1/2)."""

    __slots__ = ()

    def __new__(cls, strength: float):
        """ValueError for a wall that would take heat: its law has no such solution."""
        if strength < 0.0:
            raise ValueError(f"strength = {strength}: a vibrating wall gives heat")
        return super().__new__(cls, strength)

    def face(self, gas, n, T, half_width, guess):
        """(heat flux into the gas, wall temperature) for a last cell of density n, temperature T.

        half_width is the distance from the cell's centre to the wall. The wall is hotter than the gas: Newton's
        method from `guess`, kept between the temperatures that are known to be too low and too high.
        """
        p = gas.pressure(n, T)
        kappa = gas.conductivity(n, T)
        low, high = T, np.inf
        wall = max(guess, T)
        for _ in range(ITERATIONS):
            excess, slope = self.excess(gas, p, kappa, T, half_width, wall)
            low, high = (wall, high) if excess > 0.0 else (low, wall)
            newton = wall - excess / slope
            if not (slope < 0.0 and low <= newton <= high):
                newton = 0.5 * (low + high) if high < np.inf else 2.0 * wall
            change = newton - wall
            wall = newton
            if abs(change) <= TOLERANCE * wall:
                break
        return self.strength * gas.density(p, wall) * np.sqrt(wall), wall

    def excess(self, gas, p, kappa, T, half_width, wall):
        """Heat given by a wall of temperature `wall` less the heat conducted from it, and the slope of that."""
        n_wall = gas.density(p, wall)
        _, n_slope = gas.density_slopes(n_wall, wall)
        k_n, k_T = gas.conductivity_slopes(n_wall, wall)
        conductance = face_conductivity(kappa, gas.conductivity(n_wall, wall)) / half_width
        root = np.sqrt(wall)
        given_slope = self.strength * (n_slope * root + 0.5 * n_wall / root)
        conducted_slope = conductance + 0.5 * (k_T + k_n * n_slope) * (wall - T) / half_width
        return self.strength * n_wall * root - conductance * (wall - T), given_slope - conducted_slope

    def face_slopes(self, gas, n, T, half_width, wall):
        """(d flux/dn, d flux/dT) of the last cell, for the wall temperature that `face` found there."""
        p, (p_n, p_T) = gas.pressure(n, T), gas.pressure_slopes(n, T)
        conducted_n, conducted_T, conducted_wall = self.conducted_slopes(gas, n, T, half_width, wall)
        given_p, given_wall = self.given_slopes(gas, p, wall)
        wall_n = (conducted_n - given_p * p_n) / (given_wall - conducted_wall)
        wall_T = (conducted_T - given_p * p_T) / (given_wall - conducted_wall)
        return given_p * p_n + given_wall * wall_n, given_p * p_T + given_wall * wall_T

    def given_slopes(self, gas, p, wall):
        """Slopes of the heat strength n T^(1/2) in the pressure and in the wall temperature."""
        n_p, n_T = gas.density_slopes(gas.density(p, wall), wall)
        root = np.sqrt(wall)
        return self.strength * n_p * root, self.strength * (n_T * root + 0.5 * gas.density(p, wall) / root)


class Vibrating(TaggedLaw):
    """Feeds the heat kappa dT/dx = K W n T^(1/2), with n and T at the wall."""

    kind: Literal["vibrating"] = "vibrating"
    W: NonNegative = Field(default=114.0, title="vibration", description="K W = (2/pi)^(1/2) A^2 omega^2 / T_*")

    def law(self, **given: float) -> Any:
        return VibratingWall(strength=given["K"] * self.W)
