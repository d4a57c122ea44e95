"""Initial states of an evolution. A new state or perturbation is a model here and a line in its table."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, Strict, ValidationInfo, field_validator

from hydro.deck.fields import (
    Among,
    Axis,
    Density,
    FileName,
    Flag,
    Increasing,
    Number,
    OneOf,
    Positive,
    Primitive,
    Tagged,
    Text,
    Vector,
    Wave,
    broken_rule,
    same_length,
)

# Names that decks use; the table of the same things elsewhere holds exactly these.
LINEAR_MODES = ("heat", "sound", "shear")


class Pattern(Tagged):
    """Relative change of a density, to be multiplied onto it."""

    @property
    def largest(self) -> float:
        """Upper bound of the relative change."""
        raise NotImplementedError


class CosinePattern(Pattern):
    """n is multiplied by 1 + amplitude cos(pi wave y/aspect_ratio)."""

    kind: Literal["cosine"] = "cosine"
    amplitude: Number = Field(default=0.1, gt=-1, lt=1, description="relative amplitude")
    wave: Wave = Field(default=1, description="number of half-waves across the box in y")

    @property
    def largest(self) -> float:
        return abs(self.amplitude)


class ModesPattern(Pattern):
    """n is multiplied by 1 + the sum of amplitudes[i] cos(pi waves[i] y/aspect_ratio)."""

    kind: Literal["modes"] = "modes"
    waves: tuple[Wave, ...] = Field(min_length=1, description="numbers of half-waves across the box in y")
    amplitudes: tuple[Number, ...] = Field(
        description="relative amplitudes, one for each wave; their absolute values add to less than 1"
    )

    @field_validator("amplitudes")
    @classmethod
    def _check_amplitudes(cls, amplitudes: tuple[float, ...], info: ValidationInfo) -> tuple[float, ...]:
        same_length(amplitudes, "waves", info)
        if sum(map(abs, amplitudes)) >= 1:
            raise broken_rule("absolute values must add to less than 1")
        return amplitudes

    @property
    def largest(self) -> float:
        return sum(map(abs, self.amplitudes))


class NoisePattern(Pattern):
    """n is multiplied by 1 + noise, uniform in +-amplitude, independent from cell to cell, its mean removed."""

    kind: Literal["noise"] = "noise"
    amplitude: Number = Field(default=0.01, ge=0, lt=1, description="half-width of the distribution")
    seed: Annotated[int, Strict()] = Field(default=0, ge=0, le=2**63 - 1, description="seed of the random numbers")

    @property
    def largest(self) -> float:
        return self.amplitude


PATTERNS: dict[str, type[Pattern]] = {"cosine": CosinePattern, "modes": ModesPattern, "noise": NoisePattern}


class Initial(Tagged):
    """The state at t=0."""

    @property
    def needs_area_fraction(self) -> bool:
        """Whether the state has the mean density gas.f."""
        return False

    @property
    def largest(self) -> float:
        """Upper bound of the relative excess of the density over the area fraction, where that is known."""
        return 0.0


class MeanDensityInitial(Initial):
    """A state of given mean density gas.f and uniform temperature."""

    temperature: Positive = Field(default=1.0, description="temperature of the gas, in T_*")

    @property
    def needs_area_fraction(self) -> bool:
        return True


class CosineInitial(CosinePattern, MeanDensityInitial):
    """At rest, n = f (1 + amplitude cos(pi wave y/aspect_ratio))."""


class ModesInitial(ModesPattern, MeanDensityInitial):
    """At rest, n = f (1 + the sum of amplitudes[i] cos(pi waves[i] y/aspect_ratio))."""


class NoiseInitial(NoisePattern, MeanDensityInitial):
    """At rest, n = f (1 + noise), uniform in +-amplitude, independent from cell to cell, its mean removed."""


class UniformInitial(MeanDensityInitial):
    """Uniform density f, temperature and velocity."""

    kind: Literal["uniform"] = "uniform"
    velocity: Vector = Field(default=(0.0, 0.0), description="velocity [u, v], in T_*^(1/2)")


class WaveInitial(MeanDensityInitial):
    """A wave along x in a gas of density f."""

    amplitude: Number = Field(default=0.1, gt=-1, lt=1, description="relative amplitude of the density")

    @property
    def largest(self) -> float:
        return abs(self.amplitude)


class SimpleWaveInitial(WaveInitial):
    """A right-going sound wave of finite amplitude, n = f (1 + amplitude sin(2 pi x)), with the entropy of (f, T)."""

    kind: Literal["simple_wave"] = "simple_wave"


class DensityWaveInitial(WaveInitial):
    """n = f (1 + amplitude sin(2 pi x)) at the uniform pressure p(f, T), in a gas that moves along x."""

    kind: Literal["density_wave"] = "density_wave"
    velocity: Number = Field(default=1.0, description="velocity of the gas, in T_*^(1/2)")


class EigenmodeInitial(WaveInitial):
    """A mode of the linearized equations without cooling, one wavelength along x."""

    kind: Literal["eigenmode"] = "eigenmode"
    amplitude: Number = Field(
        default=1e-5,
        gt=-1,
        lt=1,
        description="relative amplitude of the density, small for a linear mode; of shear f times that is the velocity",
    )
    mode: Annotated[Text, Among(LINEAR_MODES)] = Field(
        default="heat",
        description="heat, which is conducted, sound, to the right, or shear, along y; "
        "as friction and viscosity have them",
    )


class ManufacturedInitial(Initial):
    """The made-up solution of hydro/exact/manufactured.py, kept by an added source; 0.35 < p < 0.65 and T about 1."""

    kind: Literal["manufactured"] = "manufactured"


class ProfileInitial(Initial):
    """Depends on one coordinate, piecewise linear between points and constant beyond the outermost."""

    kind: Literal["profile"] = "profile"
    axis: Axis = Field(default="x", description="the coordinate")
    positions: Annotated[tuple[Number, ...], Increasing] = Field(
        min_length=2, description="points along the axis, increasing, in L_x"
    )
    density: tuple[Density, ...] = Field(description="n at the points, in n_c")
    velocity: tuple[Number, ...] | None = Field(
        default=None, description="velocity along the axis; zero when not given"
    )
    transverse_velocity: tuple[Number, ...] | None = Field(
        default=None, description="velocity across the axis; zero when not given"
    )
    temperature: tuple[Positive, ...] | None = Field(
        default=None, description="T at the points, in T_*; or give pressure"
    )
    pressure: tuple[Positive, ...] | None = Field(
        default=None, description="p at the points, in n_c T_*; or give temperature"
    )

    @field_validator("density", "velocity", "transverse_velocity", "temperature", "pressure")
    @classmethod
    def _check_length(cls, values: tuple[float, ...] | None, info: ValidationInfo) -> tuple[float, ...] | None:
        if values is not None:
            same_length(values, "positions", info)
        return values

    @field_validator("pressure")
    @classmethod
    def _check_one_given(cls, pressure: tuple[float, ...] | None, info: ValidationInfo) -> tuple[float, ...] | None:
        if "temperature" in info.data and (pressure is None) == (info.data["temperature"] is None):
            raise broken_rule("give exactly one of temperature and pressure")
        return pressure


class RiemannInitial(Initial):
    """Two uniform states [n, u, p] with a jump between them; u is the velocity along the axis."""

    kind: Literal["riemann"] = "riemann"
    axis: Axis = Field(default="x", description="direction across the jump")
    position: Number = Field(
        default=0.5, gt=0, lt=1, description="place of the jump, as a fraction of the box along the axis"
    )
    left: Primitive = Field(description="[n, u, p] below the jump; 0 < n < 1, p > 0")
    right: Primitive = Field(description="[n, u, p] above the jump; 0 < n < 1, p > 0")


class CheckpointInitial(Initial):
    """The state of a checkpoint, perturbed or as it is."""

    kind: Literal["checkpoint"] = "checkpoint"
    path: FileName = Field(description="checkpoint file (.h5)")
    refill: Flag = Field(
        default=False,
        description="whether to add or take grains until the mean density is gas.f: everywhere by one factor on "
        "n/(1-n), at the same temperature and velocity; pressure then stays about uniform",
    )
    perturbation: Annotated[Pattern | None, OneOf(PATTERNS)] = Field(
        default=None, description="relative change of the density; none when not given"
    )

    @property
    def needs_area_fraction(self) -> bool:
        return self.refill


INITIALS: dict[str, type[Initial]] = {
    "cosine": CosineInitial,
    "modes": ModesInitial,
    "noise": NoiseInitial,
    "uniform": UniformInitial,
    "simple_wave": SimpleWaveInitial,
    "density_wave": DensityWaveInitial,
    "eigenmode": EigenmodeInitial,
    "manufactured": ManufacturedInitial,
    "profile": ProfileInitial,
    "riemann": RiemannInitial,
    "checkpoint": CheckpointInitial,
}
