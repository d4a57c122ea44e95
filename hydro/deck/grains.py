"""`kind = "grains"`: the grains themselves, from the deck of an evolution."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, cast

from pydantic import Field, Strict, ValidationError, ValidationInfo, field_validator

from hydro.choices import CLOSURES, DRIVES, GRAIN_COLOURS, GRAIN_WALLS, WALLS
from hydro.deck.evolution import Output, RunDeck
from hydro.deck.experiment import STAND_IN, Scaled, packed
from hydro.deck.sections import GAMMA, Gas, Sections, number_in
from hydro.schema import Chosen, Density, Named, NonNegative, Number, Positive, Section, Text, broken_rule

AT_REST = "random-phase"  # the drive whose wall does not move
OUTRIGHT = ("diameter", "restitution", "number")
ROUNDING = 1e-12  # in the 1-r^2 that follows from L, K and mu


class GrainsGas(Gas):
    """The grains: mu splits K and L into their diameter, d/L_x = K/mu, and their restitution."""

    f: Density = Field(title="area_fraction", description="average area fraction n/n_c; with d it gives their number")
    K: Positive = Field(title="conduction", description="heat conduction, mu d/L_x")

    @field_validator("mu")
    @classmethod
    def _check_mu(cls, mu: float, info: ValidationInfo) -> float:
        if {"L", "K", "gamma"} <= info.data.keys():
            loss = 3.0 * info.data["gamma"] / 32.0 * info.data["L"] * (info.data["K"] / mu) ** 2
            if loss > 1.0 + ROUNDING:
                raise broken_rule(f"no grains have the 1-r^2 = {loss:.3g} that follows from L, K and mu")
        return mu

    @property
    def diameter(self) -> float:
        """d/L_x."""
        return self.K / self.mu

    @property
    def restitution(self) -> float:
        """r, from L = (32/(3 gamma)) (L_x/d)^2 (1-r^2)."""
        return math.sqrt(max(1.0 - 3.0 * self.gamma / 32.0 * self.L * self.diameter**2, 0.0))


class Grains(Section):
    """What only grains know. Diameter and restitution take the place of L and K of the gas, their number of f."""

    diameter: Annotated[Number, Field(gt=0, lt=1)] | None = Field(default=None, description="d/L_x; K = mu d/L_x")
    restitution: Annotated[Number, Field(ge=0, le=1)] | None = Field(
        default=None, description="r; L = (32/(3 gamma)) (L_x/d)^2 (1-r^2)"
    )
    number: Annotated[int, Strict(), Field(ge=2, le=10**9)] | None = Field(
        default=None, description="how many grains; f = N 3^(1/2) d^2/(2 L_x L_y)"
    )
    seed: Annotated[int, Strict()] = Field(default=0, ge=0, le=2**63 - 1, description="seed of the random numbers")
    drive: Annotated[Text, Named(DRIVES)] = Field(
        default=AT_REST,
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

    @field_validator("number")
    @classmethod
    def _check_outright(cls, number: int | None, info: ValidationInfo) -> int | None:
        given = {key: info.data[key] for key in OUTRIGHT[:-1] if key in info.data}
        missing = [key for key, value in given.items() if value is None]
        if missing and (number is not None or len(missing) < len(given)):
            problem = "give diameter and restitution together, and number or gas.f; or none of them"
            raise broken_rule(problem, f"grains.{missing[0]}")
        return number

    def gas(self, gamma: float, mu: float, aspect_ratio: float) -> dict[str, float]:
        """What follows for the gas of grains that are given outright."""
        d, r = cast(float, self.diameter), cast(float, self.restitution)
        gas = {"L": 32.0 / (3.0 * gamma) * (1.0 - r) * (1.0 + r) / d**2, "K": mu * d}
        return gas if self.number is None else {**gas, "f": packed(self.number, d, 1.0, aspect_ratio)}


class GrainsOutput(Output):
    """What a run keeps, and when; and how grains are drawn."""

    colour: Annotated[Text, Named(GRAIN_COLOURS)] = Field(
        default="speed",
        description="of grains in pictures: by speed, or by the cluster they are in, of grains with gaps below 0.3 d",
    )


class GrainsDeck(RunDeck):
    """Event-driven molecular dynamics of inelastic smooth hard disks. They know no rolling friction."""

    scalars: ClassVar[tuple[str, ...]] = (
        "wall_max", "wall_min", "half_waves", "gas_density", "wall_max_error", "wall_min_error", "gas_density_error",
        "mean_pressure", "thermal_energy", "max_mach", "mass_drift", "grains", "collisions", "wall_seconds",
    )  # fmt: skip

    kind: Literal["grains"] = "grains"
    gas: Annotated[GrainsGas, Chosen(CLOSURES, key="closure", shared=GrainsGas)]
    wall: Annotated[Any, Chosen(WALLS, only=tuple(GRAIN_WALLS))] = Field(
        default={"kind": "vibrating"}, description="The wall at x=1"
    )
    grains: Grains = Grains()
    output: GrainsOutput = GrainsOutput()

    @field_validator("grains")
    @classmethod
    def _check_grains(cls, grains: Grains, info: ValidationInfo) -> Grains:
        if info.data.get("experiment") is not None and grains.diameter is not None:
            problem = "given beside [experiment], from which it follows; leave one out"
            raise broken_rule(problem, "grains.diameter", grains.diameter)
        return grains

    @field_validator("initial")
    @classmethod
    def _check_source(cls, initial: Any) -> Any:
        if initial.needs_terms:
            raise broken_rule("grains know no source term", "initial.kind", initial.kind)
        return initial

    @property
    def window(self) -> float:
        """Time over which fields are averaged."""
        return self.grains.window or self.time.end / 50.0

    @property
    def diameter(self) -> float:
        """d/L_x."""
        return self.gas.diameter if self.grains.diameter is None else self.grains.diameter

    @property
    def restitution(self) -> float:
        """r."""
        return self.gas.restitution if self.grains.restitution is None else self.grains.restitution

    @property
    def wall_speed(self) -> float:
        """A omega in T_*^(1/2) of a vibrating wall, from K W = (2/pi)^(1/2) A^2 omega^2/T_*; zero for another."""
        W = getattr(self.wall, "W", 0.0)
        return math.sqrt(self.gas.K * W * math.sqrt(math.pi / 2.0))

    @property
    def moving_wall(self) -> tuple[float, float] | None:
        """Amplitude and angular frequency of a driving wall that moves; None where it is at rest."""
        moves = self.grains.drive != AT_REST and self.wall_speed > 0.0
        return (self.grains.amplitude, self.wall_speed / self.grains.amplitude) if moves else None

    @classmethod
    def following(cls, scaled: Scaled) -> Sections:
        """The amplitude of the wall, too."""
        return {**super().following(scaled), "grains": {"amplitude": scaled.amplitude}}

    @classmethod
    def inferred(cls, data: Mapping[str, Any]) -> dict[str, Sections]:
        section = data.get("grains")
        given = {key for key in OUTRIGHT if key in section} if isinstance(section, dict) else set()
        if not given or "experiment" in data:
            return super().inferred(data)
        gamma, mu = number_in(data, "gas", "gamma", GAMMA), number_in(data, "gas", "mu", 1.0)
        try:
            gas = Grains.model_validate(section).gas(gamma, mu, number_in(data, "box", "aspect_ratio", 1.0))
        except (ValidationError, ArithmeticError):
            follow = ("L", "K", "f") if "number" in given else ("L", "K")
            gas = {key: getattr(STAND_IN, key) for key in follow}
        return {"grains.diameter": {"gas": gas}}

    @property
    def follows(self) -> dict[str, Sections]:
        if self.grains.diameter is None:
            return super().follows
        return {"grains.diameter": {"gas": self.grains.gas(self.gas.gamma, self.gas.mu, self.box.aspect_ratio)}}
