"""What several kinds of deck share: gas, box and mesh, and numbers that follow from an experiment.

Scaled units: length L_x, density n_c, temperature T_*, hence velocity T_*^(1/2), time L_x/T_*^(1/2), pressure n_c T_*.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, Strict, ValidationError, ValidationInfo, field_validator, model_validator

from hydro.choices import CLOSURES
from hydro.deck.experiment import STAND_IN, Experiment, Scaled
from hydro.schema import (
    Axes,
    Cells,
    Law,
    Named,
    NonNegative,
    Number,
    Positive,
    Section,
    Tagged,
    Text,
    broken_rule,
)

GAMMA = 2.26  # of Grossman, Zhou and Ben-Naim


class About(Section):
    """What the deck is and where it comes from; for people only."""

    title: Text = Field(default="", description="title shown in reports")
    reference: Text = Field(default="", description="paper, equation or figure that the deck belongs to")
    notes: Text = Field(default="", description="what a reader should know, such as assumptions that do not hold")


class Range(Section):
    """Numbers from start to stop."""

    start: Number = Field(description="the first")
    stop: Number = Field(description="the last")
    count: Annotated[int, Strict(), Field(ge=2, le=100000)] = Field(description="how many, start and stop included")
    spacing: Literal["linear", "log"] = Field(default="linear", description="equal differences or equal ratios")

    @field_validator("spacing")
    @classmethod
    def _check_spacing(cls, spacing: str, info: ValidationInfo) -> str:
        if spacing == "log" and min(info.data.get("start", 1.0), info.data.get("stop", 1.0)) <= 0.0:
            raise broken_rule("start and stop must be greater than 0 for equal ratios")
        return spacing

    @property
    def values(self) -> tuple[float, ...]:
        """All of them, from start to stop, to 15 digits."""
        shares = [k / (self.count - 1) for k in range(1, self.count - 1)]
        if self.spacing == "log":
            inner = [self.start * (self.stop / self.start) ** share for share in shares]
        else:
            inner = [self.start + (self.stop - self.start) * share for share in shares]
        return (self.start, *(float(f"{value:.15g}") for value in inner), self.stop)


class Gas(Law):
    """The granular gas: dimensionless numbers and closure; the closure's own constants stand beside it."""

    L: NonNegative = Field(
        title="collisional_loss",
        description="collisional loss, (32/(3 gamma)) (L_x/d)^2 (1-r^2); 0 for elastic grains",
    )
    f: Positive | None = Field(
        default=None,
        title="area_fraction",
        description="average area fraction n/n_c; required unless the initial state fixes the density",
    )
    K: NonNegative = Field(title="conduction", description="heat conduction, mu d/L_x; 0 for ideal flow")
    tau: Positive = Field(
        default=math.inf,
        allow_inf_nan=True,
        title="friction_time",
        description="time in which rolling friction stops the flow, in L_x/T_*^(1/2); inf for none",
    )
    gamma: Positive = Field(
        default=GAMMA, description="weight of the mean free path in the collision rate; 1-r^2 follows from L by it"
    )
    mu: Positive = Field(
        default=1.0,
        description="splits K and L into d/L_x = K/mu and 1-r^2; of order unity: "
        "dilute kinetic theory gives 2.41 from conduction, 1.42 from cooling",
    )
    closure: Annotated[Text, Named(CLOSURES)] = Field(
        default="grossman", description="equation of state, mean free path, conductivity and cooling"
    )

    @model_validator(mode="after")
    def _check_packing(self) -> Self:
        if self.made is not None and self.f is not None and self.f >= self.packing_density:
            raise broken_rule(f"must be less than {self.packing_density:g}", "gas.f", self.f)
        return self

    @property
    def packing_density(self) -> float:
        """The density at which the gas packs, in n_c."""
        return float(self.law().packing_density())


class ViscousGas(Gas):
    """The granular gas: dimensionless numbers and closure; the closure's own constants stand beside it."""

    viscosity: NonNegative = Field(
        default=0.0,
        description="shear and bulk viscosity over those that kinetic theory gives for the conductivity: 1 for grains; "
        "0 for none, as in the paper",
    )


class Box(Section):
    """The box, 0 < x < 1 and 0 < y < aspect_ratio; its walls are elastic but for the one at x=1."""

    aspect_ratio: Positive = Field(default=1.0, title="Delta", description="L_y/L_x")
    periodic: Axes = Field(default=(), description="directions that are periodic instead of walled")


class Mesh(Section):
    """The cells."""

    cells: tuple[Cells, Cells] = Field(description="number of cells along x and y")
    stretch: Number = Field(
        default=1.0,
        ge=1,
        le=1000,
        description="ratio of the widest to the narrowest cell in x; cells are finest at x=0",
    )


class ClosedBox(Section):
    """The box, 0 < x < 1 and 0 < y < aspect_ratio; its walls are elastic but for the one at x=1."""

    aspect_ratio: Positive = Field(default=1.0, title="Delta", description="L_y/L_x")


Sections = dict[str, dict[str, Any]]  # values by section and key


class Deck(Tagged):
    """What all kinds of deck have in common."""

    scalars: ClassVar[tuple[str, ...]] = ()  # numbers that describe a run of this kind, the most telling first

    about: About = About()

    @property
    def changes(self) -> list[dict[str, Any]]:
        """For studies: values by dotted key that each run has instead of those of the base deck."""
        return []

    @classmethod
    def inferred(cls, data: Mapping[str, Any]) -> dict[str, Sections]:
        """Of a deck that is not yet valid: what follows from others, by the section or key that it follows from."""
        return {}

    @property
    def follows(self) -> dict[str, Sections]:
        """What is not given but follows from others, by the section or key that it follows from."""
        return {}


class ExperimentDeck(Deck):
    """What the kinds of deck have in common whose scaled numbers may follow from an experiment."""

    experiment: Experiment | None = None

    @classmethod
    def following(cls, scaled: Scaled) -> Sections:
        """Sections and keys that follow from an experiment, where they are known."""
        gas = {key: getattr(scaled, key) for key in ("L", "f", "K", "tau", "mu")}
        return {"gas": gas, "box": {"aspect_ratio": scaled.aspect_ratio}, "wall": {"W": scaled.W}}

    @classmethod
    def inferred(cls, data: Mapping[str, Any]) -> dict[str, Sections]:
        return {"experiment": cls.following(_scaled(data))} if "experiment" in data else {}

    @property
    def scaled(self) -> Scaled | None:
        """The scaled numbers of the experiment; None without one."""
        gamma = getattr(getattr(self, "gas", None), "gamma", GAMMA)
        return None if self.experiment is None else self.experiment.scaled(gamma)

    @property
    def follows(self) -> dict[str, Sections]:
        scaled = self.scaled
        if scaled is None:
            return {}
        known = {
            name: {key: value for key, value in keys.items() if hasattr(getattr(self, name), key)}
            for name, keys in self.following(scaled).items()
        }
        return {"experiment": known}


def _scaled(data: Mapping[str, Any]) -> Scaled:
    """The scaled numbers of the experiment, or stand-ins when it is not valid: then that is complained about later."""
    gamma = number_in(data, "gas", "gamma", GAMMA)
    try:
        return Experiment.model_validate(data["experiment"]).scaled(gamma)
    except (ValidationError, OverflowError):
        return STAND_IN


def number_in(data: Mapping[str, Any], name: str, key: str, default: float) -> float:
    """A positive number of a deck that is not yet valid; the default where there is none."""
    section = data.get(name)
    value = section.get(key, default) if isinstance(section, dict) else default
    legal = isinstance(value, int | float) and not isinstance(value, bool) and 0 < value < math.inf
    return value if legal else default
