"""The driving wall at x = 1: how much heat it gives to the gas.

Each law finds the values of temperature and density *at the wall face* from those of the last cell: between
its centre and the wall the pressure is uniform, and the conducted heat is the heat that the law gives.
Taking the last cell's own values instead would be first-order accurate.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from hydro.jit import compiled_methods
from hydro.registry import Registry

WALLS: Registry[Any] = Registry("wall")

ITERATIONS = 50
TOLERANCE = 1e-8  # of the last of Newton's changes: the error left is of the order of its square


@compiled_methods
class VibratingWall(NamedTuple):
    """kappa dT/dx = K W n T^(1/2), Eq. (wall1) with q = (2/pi)^(1/2) A^2 omega^2 n T^(1/2).

    W = 0 is an elastic wall.
    """

    W: float

    def face(self, gas, n, T, half_width, guess):
        """(heat flux into the gas, wall temperature) for a last cell of density n, temperature T.

        Newton's method for the wall temperature, from `guess`; half_width is the distance from the cell's
        centre to the wall.
        """
        p = gas.pressure(n, T)
        kappa = gas.conductivity(n, T)
        wall = guess
        for _ in range(ITERATIONS):
            n_wall = gas.density(p, wall)
            p_n, p_T = gas.pressure_slopes(n_wall, wall)
            n_slope = -p_T / p_n
            k_n, k_T = gas.conductivity_slopes(n_wall, wall)
            conductance = 0.5 * (kappa + gas.conductivity(n_wall, wall)) / half_width
            root = np.sqrt(wall)
            slope = (
                conductance
                + 0.5 * (k_T + k_n * n_slope) * (wall - T) / half_width
                - gas.K * self.W * (n_slope * root + 0.5 * n_wall / root)
            )
            change = (gas.K * self.W * n_wall * root - conductance * (wall - T)) / slope
            wall = max(wall + change, 0.5 * wall)
            if abs(change) <= TOLERANCE * wall:
                break
        return gas.K * self.W * gas.density(p, wall) * np.sqrt(wall), wall


@compiled_methods
class ThermalWall(NamedTuple):
    """T = temperature at the wall."""

    temperature: float

    def face(self, gas, n, T, half_width, guess):
        """(heat flux into the gas, wall temperature), as for the vibrating wall; `guess` is not needed."""
        n_wall = gas.density(gas.pressure(n, T), self.temperature)
        conductivity = 0.5 * (gas.conductivity(n, T) + gas.conductivity(n_wall, self.temperature))
        return conductivity * (self.temperature - T) / half_width, self.temperature


WALLS.add("vibrating", VibratingWall)
WALLS.add("thermal", ThermalWall)
WALLS.add("elastic", lambda: VibratingWall(0.0))
