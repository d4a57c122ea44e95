"""The walls of the box: how much heat they give to the gas, and what lies beyond them. A file per law.

Each law finds the values of temperature and density *at the wall face* from those of the last cell: between
its centre and the wall the pressure is uniform, and the conducted heat is the heat that the law gives.
Taking the last cell's own values instead would be first-order accurate.
"""

from __future__ import annotations

from hydro.walls.elastic import ElasticWall
from hydro.walls.law import WallLaw
from hydro.walls.sides import Walls
from hydro.walls.thermal import ThermalWall
from hydro.walls.vibrating import VibratingWall

__all__ = ["ElasticWall", "ThermalWall", "VibratingWall", "WallLaw", "Walls"]
