"""Sound of finite amplitude."""

from __future__ import annotations

from typing import Any, Literal

from hydro.initial.exact import FRICTIONLESS, IDEAL, PERIODIC, Evolution, Wave, along_x, straight
from hydro.setup import gas_of


class SimpleWave(Wave):
    """A right-going sound wave of finite amplitude, n = f (1 + amplitude sin(2 pi x)), with the entropy of (f, T)."""

    exact_if = (IDEAL, FRICTIONLESS, PERIODIC)

    kind: Literal["simple_wave"] = "simple_wave"

    def evolution(self, deck: Any) -> Evolution:
        from hydro.exact import SimpleWave

        wave = SimpleWave(gas_of(deck), deck.gas.f, self.temperature, self.amplitude)
        return along_x(straight(wave.conserved))
