"""A uniform gas at rest and a small mode of the linearized equations."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from pydantic import Field

from hydro.initial.exact import ADIABATIC, PERIODIC, Evolution, Wave, along_x
from hydro.schema import Number
from hydro.setup import gas_of, viscosity_of


class Eigenmode(Wave):
    """A mode of the linearized equations without cooling, one wavelength along x."""

    exact_if = (ADIABATIC, PERIODIC)

    kind: Literal["eigenmode"] = "eigenmode"
    amplitude: Number = Field(
        default=1e-5,
        gt=-1,
        lt=1,
        description="relative amplitude of the density, small for a linear mode; of shear f times that is the velocity",
    )
    mode: Literal["heat", "sound", "shear"] = Field(
        default="heat",
        description="heat, which is conducted, sound, to the right, or shear, along y; "
        "as friction and viscosity have them",
    )

    def evolution(self, deck: Any) -> Evolution:
        from hydro.exact import linear_modes

        gas, n, T = gas_of(deck), deck.gas.f, self.temperature
        mode = linear_modes(gas, n, T, deck.gas.tau, 2.0 * np.pi, viscosity_of(deck))[self.mode]

        def conserved(x: np.ndarray, t: float) -> np.ndarray:
            dn, du, dv, dT = self.amplitude * n * mode.fields(x, t)
            energy = (n + dn) * (T + dT + 0.5 * du * du + 0.5 * dv * dv)
            return np.stack([n + dn, (n + dn) * du, (n + dn) * dv, energy])

        return along_x(conserved)
