"""Density carried along at uniform pressure."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from hydro.initial.exact import FRICTIONLESS, IDEAL, PERIODIC, Evolution, Wave, along_x, straight
from hydro.schema import Number
from hydro.setup import gas_of


class DensityWave(Wave):
    """n = f (1 + amplitude sin(2 pi x)) at the uniform pressure p(f, T), in a gas that moves along x."""

    exact_if = (IDEAL, FRICTIONLESS, PERIODIC)

    kind: Literal["density_wave"] = "density_wave"
    velocity: Number = Field(default=1.0, description="velocity of the gas, in T_*^(1/2)")

    def evolution(self, deck: Any) -> Evolution:
        from hydro.exact import DensityWave

        gas, n = gas_of(deck), deck.gas.f
        pressure = float(gas.pressure(n, self.temperature))
        return along_x(straight(DensityWave(gas, n, self.amplitude, pressure, self.velocity).conserved))
