"""The wall that holds its temperature."""

from __future__ import annotations

from typing import Any, ClassVar, Literal, NamedTuple

from pydantic import Field

from hydro.gas.conduction import face_conductivity
from hydro.methods import compiled_methods
from hydro.schema import Positive, TaggedLaw
from hydro.walls.heated import HeatedFace


class ThermalWallConstants(NamedTuple):
    """The temperature of the wall."""

    temperature: float


@compiled_methods
class ThermalWall(ThermalWallConstants, HeatedFace):
    """T = temperature at the wall."""

    __slots__ = ()

    def face(self, gas, n, T, half_width, guess):
        """(heat flux into the gas, wall temperature), as for the vibrating wall; `guess` is not needed."""
        n_wall = gas.density(gas.pressure(n, T), self.temperature)
        kappa = face_conductivity(gas.conductivity(n, T), gas.conductivity(n_wall, self.temperature))
        return kappa * (self.temperature - T) / half_width, self.temperature

    def face_slopes(self, gas, n, T, half_width, wall):
        """(d flux/dn, d flux/dT) of the last cell."""
        conducted_n, conducted_T, _ = self.conducted_slopes(gas, n, T, half_width, wall)
        return conducted_n, conducted_T


class Thermal(TaggedLaw):
    """Holds its temperature."""

    made: ClassVar[Any] = ThermalWall

    kind: Literal["thermal"] = "thermal"
    temperature: Positive = Field(default=1.0, description="temperature of the wall, in T_*")
