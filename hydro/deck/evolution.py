"""`kind = "evolution"`: the gas in time."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal, TypeVar, cast

from pydantic import Field, Strict, ValidationInfo, create_model, field_validator

from hydro.choices import CLOSURES, INITIAL_STATES, INTEGRATORS, LIMITERS, RIEMANN_SOLVERS, SCALES, TERMS, WALLS
from hydro.deck.sections import Box, ExperimentDeck, Gas, Mesh, Range, ViscousGas
from hydro.schema import (
    Chosen,
    Flag,
    Increasing,
    ListOr,
    Named,
    NonNegative,
    Number,
    Positive,
    Section,
    TaggedLaw,
    Text,
    broken_rule,
)

Colours = Literal["gray", "viridis", "cividis", "magma", "inferno"]
Limits = Literal["frame", "run"]

SHORTEST_CADENCE = 1e-6  # of the run: more often than that would fill the disk


class Timeline(Section):
    """How far to go in time."""

    end: Positive = Field(description="time at which the run ends, in L_x/T_*^(1/2)")
    wall_limit: Positive = Field(
        default=math.inf,
        allow_inf_nan=True,
        description="seconds of wall clock, from start or restart, after which the run saves its state and stops; "
        "inf for none",
    )


class Time(Timeline):
    """How far and how to step in time."""

    integrator: Annotated[Text, Named(INTEGRATORS)] = Field(
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


class Scheme(Section):
    """Reconstruction and fluxes of the flow solver."""

    limiter: Annotated[Text, Named(LIMITERS)] = Field(default="van_leer", description="slope limiter")
    riemann: Annotated[Text, Named(RIEMANN_SOLVERS)] = Field(
        default="hllc_lm", description="Riemann solver; hllc_lm is HLLC corrected for low Mach numbers"
    )


class Times(Range):
    """Times from start to stop."""

    start: NonNegative = Field(description="the first")
    stop: NonNegative = Field(description="the last")


class Output(Section):
    """What a run keeps, and when."""

    times: Annotated[tuple[NonNegative, ...] | Times, ListOr(Times)] = Field(
        default=(),
        description="times of the checkpoints, increasing, up to time.end, as a list or as "
        "{ start, stop, count, spacing }; empty means time.end alone",
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
    pictures: Flag = Field(default=True, description="whether to draw; hundreds of short runs are faster without")
    movie: Flag = Field(default=False, description="whether to keep frames, and to make a movie of them at the end")
    movie_every: Positive | None = Field(
        default=None,
        description="frames of the movie every so much scaled time, at the first step after; "
        "time.end/300 when not given",
    )


class Movie(Section):
    """How a movie looks."""

    colours: Colours = Field(
        default="gray", description="gray, where dense is dark as in the paper's figures, or a perceptual map"
    )
    scale: Annotated[Text, Named(SCALES)] = Field(
        default="linear", description="of the density: linear from zero, or log from its least value"
    )
    limits: Limits = Field(
        default="frame", description="ends of the scale: of each frame, or the same for the whole run"
    )
    traces: Flag = Field(
        default=True, description="whether the largest and smallest n on the wall x=0 are drawn under the map"
    )
    frames_per_second: Annotated[int, Strict(), Field(ge=1, le=60)] = Field(
        default=25, description="speed; less where the movie would not last eight seconds"
    )
    gif: Flag = Field(default=True, description="whether to write a small movie.gif beside movie.mp4")


def listed(times: tuple[float, ...] | Range) -> tuple[float, ...]:
    """Times that are listed, or all of a range."""
    return times.values if isinstance(times, Range) else times


class RunDeck(ExperimentDeck):
    """What all decks have in common that run in time from an initial state."""

    gas: Annotated[Gas, Chosen(CLOSURES, key="closure", shared=Gas)]
    box: Box = Box()
    mesh: Mesh
    wall: Annotated[Any, Chosen(WALLS, shared=TaggedLaw)] = Field(
        default={"kind": "vibrating"}, description="The wall at x=1"
    )
    initial: Annotated[Any, Chosen(INITIAL_STATES)] = Field(description="The state at t=0")
    time: Timeline
    output: Output = Output()
    movie: Movie = Movie()

    @field_validator("wall")
    @classmethod
    def _check_wall(cls, wall: Any, info: ValidationInfo) -> Any:
        box = info.data.get("box")
        if box is not None and "x" in box.periodic and wall.kind != "elastic":
            raise broken_rule("must be 'elastic' in a box that is periodic in x", "wall.kind", wall.kind)
        return wall

    @field_validator("initial")
    @classmethod
    def _check_initial(cls, initial: Any, info: ValidationInfo) -> Any:
        gas = info.data.get("gas")
        if gas is None or not initial.needs_area_fraction:
            return initial
        if gas.f is None:
            raise broken_rule(f"required by the initial state {initial.kind!r}: average area fraction n/n_c", "gas.f")
        if gas.f * (1 + initial.largest) >= gas.packing_density:
            raise broken_rule("the initial state reaches close packing with its amplitude", "gas.f", gas.f)
        return initial

    @field_validator("output")
    @classmethod
    def _check_output(cls, output: Output, info: ValidationInfo) -> Output:
        time = info.data.get("time")
        least = 0.0 if time is None else SHORTEST_CADENCE * time.end
        for key in ("checkpoint_every", "history_every", "movie_every"):
            every = getattr(output, key)
            if every and every < least:
                raise broken_rule(f"must be {least:g} or more, a millionth of time.end", f"output.{key}", every)
        times = listed(output.times)
        if not all(before < after for before, after in pairwise(times)):
            raise broken_rule("must increase from item to item", "output.times", output.times)
        if time is not None and times and times[-1] > time.end:
            raise broken_rule(f"must not go beyond time.end = {time.end:g}", "output.times", output.times)
        return output

    @property
    def output_times(self) -> tuple[float, ...]:
        """Times of the checkpoints that were asked for; the end alone when none were."""
        return listed(self.output.times) or (self.time.end,)

    @property
    def history_interval(self) -> float:
        """Scaled time between rows of the history file; zero for every step."""
        every = self.output.history_every
        return self.time.end / 500 if every is None else every

    @property
    def movie_interval(self) -> float:
        """Scaled time between frames of the movie."""
        return self.output.movie_every or self.time.end / 300


class EvolutionOutput(Output):
    """What a run keeps, and when."""

    collisions: Annotated[tuple[Positive, ...], Increasing] = Field(
        default=(),
        description="numbers of collisions per grain, increasing: further checkpoints at the first steps by which a "
        "gas that cools freely has reached them",
    )


class FlowingGas(ViscousGas):
    """The gas of a run."""

    elastic_below: NonNegative | None = Field(
        default=None,
        description="temperature, over T_*, below which collisions lose nothing; 0 for none. If it is not given: "
        "1e-8 before a wall that heats the gas, where packed cores get as cold, else 0",
    )


D = TypeVar("D", bound=type[Section])


def with_terms(model: D) -> D:
    """The model of a deck, with a section for each term that has one; it need not be given."""
    sections: dict[str, Any] = {name: (TERMS.section(name) | None, None) for name in TERMS.with_sections()}
    if not sections:
        return model
    return cast(D, create_model(model.__name__, __base__=model, __doc__=model.__doc__, **sections))


@with_terms
class EvolutionDeck(RunDeck):
    """Evolution of the gas in time from an initial state."""

    scalars: ClassVar[tuple[str, ...]] = (
        "wall_max", "wall_min", "half_waves", "drift", "gas_density", "mean_pressure", "max_speed", "max_mach",
        "mass_drift", "steps", "wall_seconds",
    )  # fmt: skip

    kind: Literal["evolution"] = "evolution"
    gas: Annotated[FlowingGas, Chosen(CLOSURES, key="closure", shared=FlowingGas)]
    time: Time
    scheme: Scheme = Scheme()
    output: EvolutionOutput = EvolutionOutput()

    @field_validator("output")
    @classmethod
    def _check_clock(cls, output: EvolutionOutput, info: ValidationInfo) -> EvolutionOutput:
        box, gas = info.data.get("box"), info.data.get("gas")
        if output.collisions and box is not None and gas is not None:
            cools = {"x", "y"} == set(box.periodic) and getattr(gas, "L", 0.0) > 0.0 and getattr(gas, "K", 0.0) > 0.0
            if not cools:
                problem = 'collisions are counted where box.periodic has "x" and "y", and gas.L and gas.K are not 0'
                raise broken_rule(problem, "output.collisions", output.collisions)
        return output
