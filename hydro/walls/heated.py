"""What wall laws share that heat the gas by conduction from the wall face."""

from __future__ import annotations

from hydro.gas.conduction import conducted_slope, face_conductivity
from hydro.walls.elastic import SmoothWall


class HeatedFace(SmoothWall):
    """What the laws share: smooth walls, heat conducted from the wall to the centre of the last cell."""

    def conducted_slopes(self, gas, n, T, half_width, wall):
        """Slopes, in n and T of the last cell and in the wall temperature, of the heat conducted from the wall."""
        p_n, p_T = gas.pressure_slopes(n, T)
        k_n, k_T = gas.conductivity_slopes(n, T)
        n_wall = gas.density(gas.pressure(n, T), wall)
        n_wall_p, n_wall_T = gas.density_slopes(n_wall, wall)
        wall_k_n, wall_k_T = gas.conductivity_slopes(n_wall, wall)
        conductance = face_conductivity(gas.conductivity(n, T), gas.conductivity(n_wall, wall)) / half_width
        lever = conducted_slope(1.0, T, wall) / half_width
        in_n = lever * (k_n + wall_k_n * n_wall_p * p_n)
        in_T = lever * (k_T + wall_k_n * n_wall_p * p_T) - conductance
        return in_n, in_T, lever * (wall_k_T + wall_k_n * n_wall_T) + conductance
