"""`kind = "grains"`: the grains themselves, from the deck of an evolution."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal

from pydantic import Field, Strict, ValidationInfo, field_validator

from hydro.deck.evolution import RunDeck
from hydro.deck.fields import Among, Density, NonNegative, Positive, Section, Text, broken_rule
from hydro.deck.initial import Initial, ManufacturedInitial
from hydro.deck.sections import Gas

DRIVES = ("random-phase", "sinusoidal", "sawtooth")


class GrainsGas(Gas):
    """The grains: mu splits K and L into their diameter, d/L_x = K/mu, and their restitution."""

    f: Density = Field(title="area_fraction", description="average area fraction n/n_c; with d it gives their number")
    K: Positive = Field(title="conduction", description="heat conduction, mu d/L_x")

    @field_validator("mu")
    @classmethod
    def _check_mu(cls, mu: float, info: ValidationInfo) -> float:
        if {"L", "K", "gamma"} <= info.data.keys():
            loss = 3.0 * info.data["gamma"] / 32.0 * info.data["L"] * (info.data["K"] / mu) ** 2
            if loss > 1.0:
                raise broken_rule(f"no grains have the 1-r^2 = {loss:.3g} that follows from L, K and mu")
        return mu

    @property
    def diameter(self) -> float:
        """d/L_x."""
        return self.K / self.mu

    @property
    def restitution(self) -> float:
        """r, from L = (32/(3 gamma)) (L_x/d)^2 (1-r^2)."""
        return math.sqrt(1.0 - 3.0 * self.gamma / 32.0 * self.L * self.diameter**2)


class Grains(Section):
    """What only grains know."""

    seed: Annotated[int, Strict()] = Field(default=0, ge=0, le=2**63 - 1, description="seed of the random numbers")
    drive: Annotated[Text, Among(DRIVES)] = Field(
        default="random-phase",
        description="how the vibrating wall moves: random-phase is at rest and gives the velocity change of a "
        "sinusoidal one of random phase; sinusoidal and sawtooth move, with the amplitude below and the A omega of W",
    )
    amplitude: Positive = Field(default=1e-3, lt=0.5, description="A of a wall that moves, in L_x")
    contact_time: NonNegative = Field(
        default=0.0,
        description="a collision so soon after another of either grain is elastic, against inelastic collapse; 0: none",
    )
    window: Positive | None = Field(
        default=None,
        description="time before a snapshot over which its fields are averaged; time.end/50 when not given",
    )


class GrainsDeck(RunDeck):
    """Event-driven molecular dynamics of inelastic smooth hard disks. They know no rolling friction."""

    scalars: ClassVar[tuple[str, ...]] = (
        "wall_max", "wall_min", "half_waves", "gas_density", "wall_max_error", "wall_min_error", "gas_density_error",
        "mean_pressure", "thermal_energy", "max_mach", "mass_drift", "grains", "collisions", "wall_seconds",
    )  # fmt: skip

    kind: Literal["grains"] = "grains"
    gas: GrainsGas
    grains: Grains = Grains()

    @field_validator("initial")
    @classmethod
    def _check_source(cls, initial: Initial) -> Initial:
        if isinstance(initial, ManufacturedInitial):
            raise broken_rule("grains know no source term", "initial.kind", initial.kind)
        return initial

    @property
    def window(self) -> float:
        """Time over which fields are averaged."""
        return self.grains.window or self.time.end / 50.0
