"""`kind = "stability"`: marginal stability of extended states."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import AfterValidator, Field, ValidationInfo, field_validator

from hydro.choices import CLOSURES, WALL_CONDITIONS
from hydro.deck.experiment import Scaled
from hydro.deck.sections import ExperimentDeck, Range, Sections
from hydro.schema import (
    Chosen,
    Density,
    HalfWaves,
    Law,
    ListOr,
    Named,
    Positive,
    Section,
    Text,
    broken_rule,
    some_distinct,
)


class DensityGas(Law):
    """The granular gas, as far as steady densities depend on it; L and f are those of the other sections."""

    elsewhere: ClassVar[tuple[str, ...]] = ("L", "K")

    closure: Annotated[Text, Named(CLOSURES)] = Field(
        default="grossman", description="equation of state, mean free path, conductivity and cooling"
    )


class AreaFractions(Range):
    """Area fractions from start to stop."""

    start: Density = Field(description="the first")
    stop: Density = Field(description="the last, greater than start")

    @field_validator("stop")
    @classmethod
    def _check_stop(cls, stop: float, info: ValidationInfo) -> float:
        start = info.data.get("start")
        if start is not None and stop <= start:
            raise broken_rule(f"must be greater than start, {start:g}")
        return stop


class MarkedPoint(Section):
    """A point to mark in the picture of a tongue."""

    f: Density = Field(title="area_fraction", description="its area fraction")
    aspect_ratio: Positive = Field(title="Delta", description="its aspect ratio L_y/L_x")
    label: Text = Field(default="", description="what to write beside it")


class Stability(Section):
    """Extended states whose critical aspect ratios are wanted."""

    L: Annotated[tuple[Positive, ...], AfterValidator(some_distinct)] = Field(
        title="collisional_loss", description="collisional losses"
    )
    f: Annotated[tuple[Density, ...] | AreaFractions, ListOr(AreaFractions)] = Field(
        title="area_fraction", description="area fractions: a list, or a section with start, stop and count"
    )
    walls: Annotated[tuple[Annotated[Text, Named(WALL_CONDITIONS)], ...], AfterValidator(some_distinct)] = Field(
        default=("vibrating",), description="kinds of the wall at x=1"
    )
    waves: Annotated[tuple[HalfWaves, ...], AfterValidator(some_distinct)] = Field(
        default=(1,), description="numbers m of half-waves across the box in y"
    )
    points: tuple[MarkedPoint, ...] = Field(default=(), description="points to mark in the picture of a single L")

    @field_validator("f")
    @classmethod
    def _check_f(cls, f: tuple[float, ...] | AreaFractions) -> tuple[float, ...] | AreaFractions:
        return f if isinstance(f, AreaFractions) else some_distinct(f)

    @property
    def area_fractions(self) -> tuple[float, ...]:
        """All area fractions."""
        return self.f.values if isinstance(self.f, AreaFractions) else self.f


class StabilityDeck(ExperimentDeck):
    """Critical aspect ratios of extended states, and the tongues in which they exist."""

    scalars: ClassVar[tuple[str, ...]] = ("aspect_ratio", "f1", "f2", "f_min", "aspect_ratio_min", "wall_seconds")

    kind: Literal["stability"] = "stability"
    gas: Annotated[DensityGas, Chosen(CLOSURES, key="closure", shared=DensityGas)] = Field(default={})  # type: ignore[assignment]
    stability: Stability

    @classmethod
    def following(cls, scaled: Scaled) -> Sections:
        """The L of an experiment, and its place in the picture."""
        place = {"f": scaled.f, "aspect_ratio": scaled.aspect_ratio, "label": "experiment"}
        return {"stability": {"L": (scaled.L,), "points": (place,)}}
