"""`kind = "evolution"`: the gas in time."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, Strict, ValidationInfo, field_validator

from hydro.deck.fields import Among, Increasing, NonNegative, Number, OneOf, Positive, Section, Text, broken_rule
from hydro.deck.initial import INITIALS, Initial, Pattern
from hydro.deck.sections import WALLS, Box, Deck, Elastic, Gas, Mesh, Vibrating, Wall

# Names that decks use; the registries of the same things elsewhere hold exactly these.
INTEGRATORS = ("godunov", "lagrange-remap")
LIMITERS = ("minmod", "van_leer", "mc")
RIEMANN_SOLVERS = ("hllc", "hllc_lm")

SHORTEST_CADENCE = 1e-6  # of the run: more often than that would fill the disk


class Time(Section):
    """How far and how to step in time."""

    end: Positive = Field(description="time at which the run ends, in L_x/T_*^(1/2)")
    integrator: Annotated[Text, Among(INTEGRATORS)] = Field(
        default="godunov",
        description="time integrator: godunov (explicit: sound and shocks) or lagrange-remap (implicit: slow flow)",
    )
    cfl: Number = Field(
        default=0.8,
        gt=0,
        le=1,
        description="step: for godunov as a fraction of the time in which sound crosses half a cell, "
        "for lagrange-remap the largest share of a cell that the gas may cross",
    )
    tolerance: Positive = Field(
        default=3e-4,
        description="of lagrange-remap: root mean square change in a step, relative, that the last two states do not "
        "foresee; godunov does not use it",
    )
    dt_max: Positive | None = Field(
        default=None, description="upper bound of the step, in L_x/T_*^(1/2); none when not given"
    )
    wall_limit: Positive = Field(
        default=math.inf,
        allow_inf_nan=True,
        description="seconds of wall clock, from start or restart, after which the run saves its state and stops; "
        "inf for none",
    )


class Scheme(Section):
    """Reconstruction and fluxes of the flow solver."""

    limiter: Annotated[Text, Among(LIMITERS)] = Field(default="van_leer", description="slope limiter")
    riemann: Annotated[Text, Among(RIEMANN_SOLVERS)] = Field(
        default="hllc_lm", description="Riemann solver; hllc_lm is HLLC corrected for low Mach numbers"
    )


class Output(Section):
    """What a run keeps, and when."""

    times: Annotated[tuple[NonNegative, ...], Increasing] = Field(
        default=(), description="times of the checkpoints, increasing, up to time.end; empty means time.end alone"
    )
    checkpoint_every: Positive | None = Field(
        default=None, description="extra checkpoints every so much scaled time; none when not given"
    )
    checkpoint_seconds: Positive = Field(
        default=600.0,
        allow_inf_nan=True,
        description="extra checkpoints every so many seconds of wall clock; inf for none",
    )
    keep: Annotated[int, Strict()] | None = Field(
        default=None,
        ge=1,
        description="number of checkpoints to keep, the newest, beside those at `times`; when not given all of "
        "`checkpoint_every`, and two of those by wall clock or signal",
    )
    history_every: NonNegative | None = Field(
        default=None,
        description="rows of the history file every so much scaled time, 0 for every step; time.end/500 when not given",
    )


class EvolutionDeck(Deck):
    """Evolution of the gas in time from an initial state."""

    kind: Literal["evolution"] = "evolution"
    gas: Gas
    box: Box = Box()
    mesh: Mesh
    wall: Annotated[Wall, OneOf(WALLS)] = Vibrating()
    initial: Annotated[Initial, OneOf(INITIALS)]
    time: Time
    scheme: Scheme = Scheme()
    output: Output = Output()

    @field_validator("wall")
    @classmethod
    def _check_wall(cls, wall: Wall, info: ValidationInfo) -> Wall:
        box = info.data.get("box")
        if box is not None and "x" in box.periodic and not isinstance(wall, Elastic):
            raise broken_rule("must be 'elastic' in a box that is periodic in x", "wall.kind", wall.kind)
        return wall

    @field_validator("initial")
    @classmethod
    def _check_initial(cls, initial: Initial, info: ValidationInfo) -> Initial:
        gas = info.data.get("gas")
        if gas is None or not initial.needs_area_fraction:
            return initial
        if gas.f is None:
            raise broken_rule(f"required by the initial state {initial.kind!r}: average area fraction n/n_c", "gas.f")
        if isinstance(initial, Pattern) and gas.f * (1 + initial.largest) >= 1:
            raise broken_rule("the initial state reaches close packing with its amplitude", "gas.f", gas.f)
        return initial

    @field_validator("output")
    @classmethod
    def _check_output(cls, output: Output, info: ValidationInfo) -> Output:
        time = info.data.get("time")
        least = 0.0 if time is None else SHORTEST_CADENCE * time.end
        for key in ("checkpoint_every", "history_every"):
            every = getattr(output, key)
            if every and every < least:
                raise broken_rule(f"must be {least:g} or more, a millionth of time.end", f"output.{key}", every)
        if time is not None and output.times and output.times[-1] > time.end:
            raise broken_rule(f"must not go beyond time.end = {time.end:g}", "output.times", output.times)
        return output

    @property
    def output_times(self) -> tuple[float, ...]:
        """Times of the checkpoints that were asked for; the end alone when none were."""
        return self.output.times or (self.time.end,)

    @property
    def history_interval(self) -> float:
        """Scaled time between rows of the history file; zero for every step."""
        every = self.output.history_every
        return self.time.end / 500 if every is None else every
