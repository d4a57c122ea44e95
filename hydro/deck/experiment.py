"""`[experiment]`: the gas, the box and the wall in physical units, and the scaled numbers that follow from them.

With n_c = 2/(3^(1/2) d^2), grain mass 1 and the unit of temperature T_* = A^2 omega^2, unless the deck gives another:

    L     = (32/(3 gamma)) (L_x/d)^2 (1-r^2)
    f     = n/n_c = N 3^(1/2) d^2/(2 L_x L_y) = phi 2 3^(1/2)/pi
    K     = mu d/L_x
    K W   = (2/pi)^(1/2) A^2 omega^2/T_*
    Delta = L_y/L_x
    tau   = (8/pi)^(1/2) A omega/(mu_r g), in L_x/T_*^(1/2)

Rolling friction slows every grain down at the constant rate mu_r g, whatever its speed. Averaged over grains of
temperature T it stops a slow flow in the time (8 T/pi)^(1/2)/(mu_r g), here for T = A^2 omega^2: docs/experiment.md.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from pydantic import Field, Strict, ValidationInfo, field_validator

from hydro.deck.quantities import ACCELERATION, ANGULAR_FREQUENCY, FREQUENCY, LENGTH, TEMPERATURE
from hydro.schema import Density, NonNegative, Number, Section, Text, broken_rule

CLOSE_PACKED = math.pi / (2.0 * math.sqrt(3.0))  # phi of disks at n = n_c


class Scaled(NamedTuple):
    """The scaled numbers of an experiment; those that decks have by the names of their keys."""

    L: float
    f: float
    K: float
    tau: float
    mu: float
    aspect_ratio: float
    W: float
    amplitude: float  # A/L_x
    frequency: float  # omega L_x/T_*^(1/2)

    @property
    def wall_speed(self) -> float:
        """A omega/T_*^(1/2)."""
        return self.amplitude * self.frequency


# Of a section that is not valid, so that the rest of its deck can be looked at.
STAND_IN = Scaled(1e4, 1e-3, 1e-2, math.inf, 1.0, 1.0, 1e2, 1e-3, 1e3)


class Experiment(Section):
    """Optional: what stands on the table, in physical units, instead of the scaled numbers that follow from it."""

    d: Annotated[Text, LENGTH] = Field(title="diameter", description="diameter of the grains")
    L_x: Annotated[Text, LENGTH] = Field(
        title="length", description="length of the box, from the elastic to the driving wall"
    )
    L_y: Annotated[Text, LENGTH] = Field(title="width", description="width of the box, along the driving wall")
    N: Annotated[int, Strict(), Field(ge=1, le=10**15)] | None = Field(
        default=None, title="grains", description="number of grains; or give f or phi"
    )
    f: Density | None = Field(
        default=None,
        title="area_fraction",
        description="number density over that of close packing, n/n_c with n_c = 2/(3^(1/2) d^2); or give N or phi",
    )
    phi: Annotated[Number, Field(gt=0, lt=CLOSE_PACKED)] | None = Field(
        default=None,
        title="covered_area",
        description="share of the area that disks cover, n pi d^2/4 = 0.9069 f; or give N or f",
    )
    r: Annotated[Number, Field(ge=0, le=1)] = Field(
        title="restitution", description="coefficient of normal restitution of two grains"
    )
    A: Annotated[Text, LENGTH] = Field(
        title="amplitude", description="amplitude of the driving wall, x = L_x + A cos(omega t)"
    )
    frequency: Annotated[Text | None, FREQUENCY] = Field(
        default=None, description="omega/(2 pi) of the driving wall; or give omega"
    )
    omega: Annotated[Text | None, ANGULAR_FREQUENCY] = Field(
        default=None,
        title="angular_frequency",
        description="angular frequency of the driving wall; or give frequency",
    )
    mu: Number = Field(
        default=1.0,
        ge=0.01,
        le=100,
        description="weight of the heat conduction, of order unity: "
        "dilute kinetic theory gives 2.41 from conduction, 1.42 from cooling",
    )
    rolling_friction: NonNegative = Field(
        default=0.0,
        title="friction",
        description="deceleration of a rolling grain over gravity, mu_r; 0 for none",
    )
    gravity: Annotated[Text, ACCELERATION] = Field(
        default="9.81 m/s^2", description="what presses the grains on the plate"
    )
    temperature_scale: Annotated[Text | None, TEMPERATURE] = Field(
        default=None, description="T_* for grains of mass 1; A^2 omega^2 when not given"
    )

    @field_validator("L_x", "L_y")
    @classmethod
    def _check_side(cls, side: str, info: ValidationInfo) -> str:
        if "d" in info.data and LENGTH.si(side) <= LENGTH.si(info.data["d"]):
            raise broken_rule(f"must be longer than a grain, {info.data['d']}")
        return side

    @field_validator("phi")
    @classmethod
    def _check_density(cls, phi: float | None, info: ValidationInfo) -> float | None:
        if not {"N", "f"} <= info.data.keys():
            return phi
        if [info.data["N"], info.data["f"], phi].count(None) != 2:
            raise broken_rule("give exactly one of N, f and phi", "experiment.N")
        if info.data["N"] is not None and {"d", "L_x", "L_y"} <= info.data.keys():
            d, L_x, L_y = (LENGTH.si(info.data[key]) for key in ("d", "L_x", "L_y"))
            if (f := packed(info.data["N"], d, L_x, L_y)) >= 1.0:
                problem = f"so many grains do not fit into the box: n/n_c would be {f:.4g}, it must be less than 1"
                raise broken_rule(problem, "experiment.N", info.data["N"])
        return phi

    @field_validator("omega")
    @classmethod
    def _check_omega(cls, omega: str | None, info: ValidationInfo) -> str | None:
        if "frequency" in info.data and (omega is None) == (info.data["frequency"] is None):
            raise broken_rule("give exactly one of frequency and omega", "experiment.frequency")
        return omega

    @property
    def length(self) -> float:
        """L_x in m, the unit of length."""
        return LENGTH.si(self.L_x)

    @property
    def temperature(self) -> float:
        """T_* in m^2/s^2, the unit of temperature for grains of mass 1."""
        given = self.temperature_scale
        return self.wall_speed * self.wall_speed if given is None else TEMPERATURE.si(given)

    @property
    def speed(self) -> float:
        """T_*^(1/2) in m/s, the unit of velocity."""
        return math.sqrt(self.temperature)

    @property
    def time(self) -> float:
        """L_x/T_*^(1/2) in s, the unit of time."""
        return self.length / self.speed

    @property
    def density(self) -> float:
        """n_c in 1/m^2, the unit of density."""
        return 1.0 / packed(1, LENGTH.si(self.d), 1.0, 1.0)

    @property
    def angular_frequency(self) -> float:
        """omega in 1/s."""
        if self.omega is not None:
            return ANGULAR_FREQUENCY.si(self.omega)
        return 2.0 * math.pi * FREQUENCY.si(self.frequency)

    @property
    def wall_speed(self) -> float:
        """A omega in m/s."""
        return LENGTH.si(self.A) * self.angular_frequency

    @property
    def area_fraction(self) -> float:
        """n/n_c."""
        if self.N is not None:
            return packed(self.N, LENGTH.si(self.d), self.length, LENGTH.si(self.L_y))
        return self.phi / CLOSE_PACKED if self.phi is not None else self.f  # type: ignore[return-value]

    @property
    def friction_time(self) -> float:
        """tau in L_x/T_*^(1/2)."""
        braking = self.rolling_friction * ACCELERATION.si(self.gravity) * self.time
        return math.sqrt(8.0 / math.pi) * self.wall_speed / braking if braking > 0.0 else math.inf

    def scaled(self, gamma: float) -> Scaled:
        """The scaled numbers, with the `gamma` of the closure."""
        d, L_x = LENGTH.si(self.d), self.length
        K = self.mu * d / L_x
        return Scaled(
            L=32.0 / (3.0 * gamma) * (L_x / d) * (L_x / d) * (1.0 - self.r) * (1.0 + self.r),
            f=self.area_fraction,
            K=K,
            tau=self.friction_time,
            mu=self.mu,
            aspect_ratio=LENGTH.si(self.L_y) / L_x,
            W=math.sqrt(2.0 / math.pi) * (self.wall_speed / self.speed) ** 2 / K,
            amplitude=LENGTH.si(self.A) / L_x,
            frequency=self.angular_frequency * self.time,
        )

    @property
    def units(self) -> dict[str, tuple[float, str]]:
        """The units of the scaled numbers, by name: how many of which SI unit."""
        return {
            "length L_x": (self.length, "m"),
            "density n_c": (self.density, "1/m^2"),
            "temperature T_*": (self.temperature, "m^2/s^2"),
            "velocity T_*^(1/2)": (self.speed, "m/s"),
            "time L_x/T_*^(1/2)": (self.time, "s"),
        }


def packed(N: int, d: float, L_x: float, L_y: float) -> float:
    """n/n_c of N disks of diameter d in a box: N/(L_x L_y) over 2/(3^(1/2) d^2)."""
    return 0.5 * math.sqrt(3.0) * N * (d / L_x) * (d / L_y)
