"""What a deck may say: sections, keys, defaults and bounds, each documented where it is declared.

Scaled units: length L_x, density n_c, temperature T_*, hence velocity T_*^(1/2), time L_x/T_*^(1/2), pressure n_c T_*.
A new wall, initial state, perturbation or deck kind is a model here and a line in its table.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal, get_args, get_origin

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, Strict, ValidationInfo, field_validator
from pydantic.annotated_handlers import GetCoreSchemaHandler
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from hydro.registry import nearest

# Names that decks use; the registries of the same things elsewhere hold exactly these.
CLOSURES = ("grossman",)
INTEGRATORS = ("godunov",)
PARAMETERS = ("f", "aspect_ratio", "L")
SEARCHES = ("relaxation", "branch")
LIMITERS = ("minmod", "van_leer", "mc")
RIEMANN_SOLVERS = ("hllc", "hllc_lm")
STABILITY_WALLS = ("vibrating", "thermal")


SHORTEST_CADENCE = 1e-6  # of the run: more often than that would fill the disk


def broken_rule(problem: str, key: str = "", value: object = None) -> PydanticCustomError:
    """The error for a broken rule; `key` (dotted, from the top) and its `value` when another key is to blame."""
    return PydanticCustomError("rule", "{problem}", {"problem": problem, "key": key, "value": value})


def unknown_name(name: str, known: tuple[str, ...]) -> PydanticCustomError:
    """The error for a name that is not among `known`; carries the nearest one."""
    context = {"known": known, "nearest": nearest(name, known)}
    return PydanticCustomError("unknown_name", "unknown name", context)


@dataclass(frozen=True)
class Among:
    """Marks a text field that must be one of `names`."""

    names: tuple[str, ...]

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_after_validator_function(self._check, handler(source))

    def _check(self, name: str) -> str:
        if name not in self.names:
            raise unknown_name(name, self.names)
        return name


@dataclass(frozen=True)
class OneOf:
    """Marks a tagged section: its `kind` picks the model from `table`."""

    table: Mapping[str, type[Tagged]]

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        choices = {name: handler.generate_schema(model) for name, model in self.table.items()}
        tagged = core_schema.tagged_union_schema(choices, discriminator="kind")
        return core_schema.nullable_schema(tagged) if type(None) in get_args(source) else tagged


@dataclass(frozen=True)
class ListOr:
    """Marks a list that may also be given as a section from which it follows."""

    section: type[Section]

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        listed, *_ = (part for part in get_args(source) if get_origin(part) is tuple)
        choices = {"list": handler.generate_schema(listed), "section": handler.generate_schema(self.section)}
        return core_schema.tagged_union_schema(choices, discriminator=self._choice)

    def _choice(self, value: Any) -> str:
        return "section" if isinstance(value, dict | self.section) else "list"


class Section(BaseModel):
    """Base of all sections: frozen, unknown keys refused, numbers finite unless a field says otherwise."""

    model_config = ConfigDict(extra="forbid", frozen=True, validate_default=True, allow_inf_nan=False)


def _increasing(values: tuple[float, ...]) -> tuple[float, ...]:
    if any(after <= before for before, after in pairwise(values)):
        raise broken_rule("must increase from item to item")
    return values


def _distinct(values: tuple[Any, ...]) -> tuple[Any, ...]:
    if len(set(values)) < len(values):
        raise broken_rule("must not repeat an item")
    return values


def _some_distinct(values: tuple[Any, ...]) -> tuple[Any, ...]:
    if not values:
        raise broken_rule("must have an item")
    return _distinct(values)


def _file_name(name: str) -> str:
    if not name or not name.isprintable():
        raise broken_rule("must be the name of a file")
    return name


Number = Annotated[float, Strict()]
Positive = Annotated[Number, Field(gt=0)]
NonNegative = Annotated[Number, Field(ge=0)]
Density = Annotated[Number, Field(gt=0, lt=1)]
Text = Annotated[str, Strict()]
Flag = Annotated[bool, Strict()]
Axis = Annotated[Text, Among(("x", "y"))]
Cells = Annotated[int, Strict(), Field(ge=4, le=16384)]
Wave = Annotated[int, Strict(), Field(ge=0, le=16384)]
HalfWaves = Annotated[int, Strict(), Field(ge=1, le=16384)]
Vector = tuple[Number, Number]
Primitive = tuple[Density, Number, Positive]


class Tagged(Section):
    """Base of sections whose `kind` picks the model."""

    kind: str


class About(Section):
    """What the deck is and where it comes from; for people only."""

    title: Text = Field(default="", description="title shown in reports")
    reference: Text = Field(default="", description="paper, equation or figure that the deck belongs to")


class Gas(Section):
    """The granular gas: closure and dimensionless numbers."""

    L: NonNegative = Field(
        title="collisional_loss",
        description="collisional loss, (32/(3 gamma)) (L_x/d)^2 (1-r^2); 0 for elastic grains",
    )
    f: Density | None = Field(
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
    alpha: Positive = Field(default=1.15, description="weight of the mean free path in the heat conductivity")
    gamma: Positive = Field(
        default=2.26, description="weight of the mean free path in the collision rate; 1-r^2 follows from L by it"
    )
    mu: Positive = Field(
        default=1.0,
        description="splits K and L into d/L_x = K/mu and 1-r^2; of order unity: "
        "dilute kinetic theory gives 2.41 from conduction, 1.42 from cooling",
    )
    closure: Annotated[Text, Among(CLOSURES)] = Field(
        default="grossman", description="equation of state, mean free path, conductivity and cooling"
    )


class Box(Section):
    """The box, 0 < x < 1 and 0 < y < aspect_ratio; its walls are elastic but for the one at x=1."""

    aspect_ratio: Positive = Field(default=1.0, title="Delta", description="L_y/L_x")
    periodic: Annotated[tuple[Axis, ...], AfterValidator(_distinct)] = Field(
        default=(), description="directions that are periodic instead of walled"
    )


class Mesh(Section):
    """The cells."""

    cells: tuple[Cells, Cells] = Field(description="number of cells along x and y")
    stretch: Number = Field(
        default=1.0,
        ge=1,
        le=1000,
        description="ratio of the widest to the narrowest cell in x; cells are finest at x=0",
    )


class Wall(Tagged):
    """The wall at x=1."""


class Vibrating(Wall):
    """Feeds the heat kappa dT/dx = K W n T^(1/2), with n and T at the wall."""

    kind: Literal["vibrating"] = "vibrating"
    W: NonNegative = Field(default=114.0, title="vibration", description="K W = (2/pi)^(1/2) A^2 omega^2 / T_*")


class Thermal(Wall):
    """Holds its temperature."""

    kind: Literal["thermal"] = "thermal"
    temperature: Positive = Field(default=1.0, description="temperature of the wall, in T_*")


class Elastic(Wall):
    """Lets no heat through; also the choice where x is periodic."""

    kind: Literal["elastic"] = "elastic"


WALLS: dict[str, type[Wall]] = {"vibrating": Vibrating, "thermal": Thermal, "elastic": Elastic}


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
        _same_length(amplitudes, "waves", info)
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

    needs_area_fraction: ClassVar[bool] = False


class MeanDensityInitial(Initial):
    """A state of given mean density gas.f and uniform temperature."""

    needs_area_fraction: ClassVar[bool] = True

    temperature: Positive = Field(default=1.0, description="temperature of the gas, in T_*")


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


class ProfileInitial(Initial):
    """Depends on one coordinate, piecewise linear between points and constant beyond the outermost."""

    kind: Literal["profile"] = "profile"
    axis: Axis = Field(default="x", description="the coordinate")
    positions: Annotated[tuple[Number, ...], AfterValidator(_increasing)] = Field(
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
            _same_length(values, "positions", info)
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
    path: Annotated[Text, AfterValidator(_file_name)] = Field(description="checkpoint file (.h5)")
    perturbation: Annotated[Pattern | None, OneOf(PATTERNS)] = Field(
        default=None, description="relative change of the density; none when not given"
    )


INITIALS: dict[str, type[Initial]] = {
    "cosine": CosineInitial,
    "modes": ModesInitial,
    "noise": NoiseInitial,
    "uniform": UniformInitial,
    "profile": ProfileInitial,
    "riemann": RiemannInitial,
    "checkpoint": CheckpointInitial,
}


class Time(Section):
    """How far and how to step in time."""

    end: Positive = Field(description="time at which the run ends, in L_x/T_*^(1/2)")
    integrator: Annotated[Text, Among(INTEGRATORS)] = Field(default="godunov", description="time integrator")
    cfl: Number = Field(
        default=0.8, gt=0, le=1, description="step, as a fraction of the time in which sound crosses half a cell"
    )
    tolerance: Positive | None = Field(
        default=None, description="error tolerance of integrators that control their error; godunov does not"
    )
    dt_max: Positive | None = Field(
        default=None, description="upper bound of the step, in L_x/T_*^(1/2); none when not given"
    )


class Scheme(Section):
    """Reconstruction and fluxes of the flow solver."""

    limiter: Annotated[Text, Among(LIMITERS)] = Field(default="van_leer", description="slope limiter")
    riemann: Annotated[Text, Among(RIEMANN_SOLVERS)] = Field(
        default="hllc_lm", description="Riemann solver; hllc_lm is HLLC corrected for low Mach numbers"
    )


class Output(Section):
    """What a run keeps, and when."""

    times: Annotated[tuple[NonNegative, ...], AfterValidator(_increasing)] = Field(
        default=(), description="times of the checkpoints, increasing, up to time.end; empty means time.end alone"
    )
    checkpoint_every: Positive | None = Field(
        default=None, description="extra checkpoints every so much scaled time; none when not given"
    )
    history_every: Positive | None = Field(
        default=None, description="rows of the history file every so much scaled time; time.end/500 when not given"
    )


class Deck(Section):
    """What all kinds of deck have in common."""

    kind: str
    about: About = About()


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
            if every is not None and every < least:
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
        """Scaled time between rows of the history file."""
        return self.output.history_every or self.time.end / 500


class SteadyGas(Gas):
    """The granular gas. Densities of steady states know only L and f; K and tau set the time scale of growth rates."""

    L: Positive = Field(title="collisional_loss", description="collisional loss, (32/(3 gamma)) (L_x/d)^2 (1-r^2)")
    f: Density = Field(title="area_fraction", description="average area fraction n/n_c")
    K: Positive = Field(default=2e-3, title="conduction", description="heat conduction, mu d/L_x")
    tau: Positive = Field(
        default=200.0,
        allow_inf_nan=True,
        title="friction_time",
        description="time in which rolling friction stops the flow, in L_x/T_*^(1/2); inf for none",
    )


class ClosedBox(Section):
    """The box, 0 < x < 1 and 0 < y < aspect_ratio; its walls are elastic but for the one at x=1."""

    aspect_ratio: Positive = Field(default=1.0, title="Delta", description="L_y/L_x")


class DrivingVibrating(Vibrating):
    """Feeds the heat kappa dT/dx = K W n T^(1/2), with n and T at the wall. Steady densities do not depend on W."""

    W: Positive = Field(default=114.0, title="vibration", description="K W = (2/pi)^(1/2) A^2 omega^2 / T_*")


DRIVING_WALLS: dict[str, type[Wall]] = {"vibrating": DrivingVibrating, "thermal": Thermal}


class Steady(Section):
    """Which steady state."""

    wave: Wave = Field(
        default=1, description="number of half-waves across the box in y; 0 is the extended state, 2 or more are chains"
    )
    shifted: Flag = Field(
        default=False,
        description="whether the first cluster is half a wave away from y=0, not in that corner: "
        "for wave=2, one cluster in the middle instead of two in the corners",
    )
    search: Annotated[Text, Among(SEARCHES)] = Field(
        default="relaxation",
        description="how to find it: relaxation of a gas pushed to one side, which ends in a stable half-wave; "
        "branch: the first state on the branch from the nearest bifurcation in f, unstable beyond a subcritical one",
    )
    modes: Annotated[int, Strict(), Field(ge=1, le=16)] = Field(
        default=3, description="number of leading eigenmodes to keep in each symmetry sector"
    )
    mode_amplitude: Number = Field(
        default=1e-3,
        gt=0,
        lt=0.5,
        description="largest relative change of the density in the checkpoints of the state plus an eigenmode",
    )


class SteadyDeck(Deck):
    """A steady state in two dimensions, on the finite volumes of the evolution, and its growth rates."""

    kind: Literal["steady"] = "steady"
    gas: SteadyGas
    box: ClosedBox = ClosedBox()
    mesh: Mesh
    wall: Annotated[Wall, OneOf(DRIVING_WALLS)] = DrivingVibrating()
    steady: Steady = Steady()

    @field_validator("steady")
    @classmethod
    def _check_steady(cls, steady: Steady, info: ValidationInfo) -> Steady:
        _divisible(info.data.get("mesh"), steady.wave, "steady.wave")
        return steady


class BranchGas(SteadyGas):
    """The granular gas, but for the parameter that the branch is followed in."""

    L: Positive | None = Field(  # type: ignore[assignment]
        default=None, title="collisional_loss", description="collisional loss; required unless it is the parameter"
    )
    f: Density | None = Field(  # type: ignore[assignment]
        default=None, title="area_fraction", description="average area fraction; required unless it is the parameter"
    )


class Branch(Section):
    """Which branch: where it leaves the extended state, and how far to follow it."""

    parameter: Annotated[Text, Among(PARAMETERS)] = Field(
        default="f", description="what changes along the branch: area fraction, aspect ratio or L"
    )
    wave: Annotated[int, Strict(), Field(ge=1, le=16384)] = Field(
        default=1, description="number of half-waves across the box in y"
    )
    start: Positive = Field(description="one end of the range of the parameter")
    stop: Positive = Field(description="the other end")
    samples: Annotated[int, Strict(), Field(ge=2, le=10000)] = Field(
        default=25, description="extended states computed in the range; bifurcations are looked for between them"
    )
    step: Number = Field(
        default=0.1,
        gt=0,
        le=2,
        description="longest step along the branch: root mean square of the change of log(1/n-1), "
        "and ten times that of the logarithm of the parameter",
    )
    points: Annotated[int, Strict(), Field(ge=1, le=100000)] = Field(
        default=400, description="largest number of points on one branch"
    )


class BranchDeck(Deck):
    """Branches of localized states, from where they leave the extended state, through folds, to the end of a range."""

    kind: Literal["branch"] = "branch"
    gas: BranchGas = BranchGas()
    box: ClosedBox = ClosedBox()
    mesh: Mesh
    wall: Annotated[Wall, OneOf(DRIVING_WALLS)] = DrivingVibrating()
    branch: Branch

    @field_validator("branch")
    @classmethod
    def _check_branch(cls, branch: Branch, info: ValidationInfo) -> Branch:
        gas = info.data.get("gas")
        if branch.start == branch.stop:
            raise broken_rule("must differ from branch.start", "branch.stop", branch.stop)
        if branch.parameter == "f":
            for key in ("start", "stop"):
                if getattr(branch, key) >= 1:
                    raise broken_rule("must be less than 1", f"branch.{key}", getattr(branch, key))
        for key in ("L", "f"):
            if gas is not None and branch.parameter != key and getattr(gas, key) is None:
                raise broken_rule(f"required, since the branch is followed in {branch.parameter}", f"gas.{key}")
        _divisible(info.data.get("mesh"), branch.wave, "branch.wave")
        return branch


def _divisible(mesh: Mesh | None, wave: int, key: str) -> None:
    if mesh is None or wave == 0:
        return
    if mesh.cells[1] % wave or mesh.cells[1] // wave < 4:
        problem = f"mesh.cells[1] = {mesh.cells[1]} must be a multiple of it, four times or more"
        raise broken_rule(problem, key, wave)


class DensityGas(Section):
    """The granular gas, as far as steady densities depend on it; L and f are those of the other sections."""

    alpha: Positive = Field(default=1.15, description="weight of the mean free path in the heat conductivity")
    closure: Annotated[Text, Among(CLOSURES)] = Field(
        default="grossman", description="equation of state, mean free path, conductivity and cooling"
    )


class AreaFractions(Section):
    """Area fractions from start to stop."""

    start: Density = Field(description="the first")
    stop: Density = Field(description="the last, greater than start")
    count: Annotated[int, Strict(), Field(ge=2, le=100000)] = Field(description="how many, start and stop included")
    spacing: Annotated[Text, Among(("linear", "log"))] = Field(
        default="linear", description="equal differences or equal ratios"
    )

    @field_validator("stop")
    @classmethod
    def _check_stop(cls, stop: float, info: ValidationInfo) -> float:
        start = info.data.get("start")
        if start is not None and stop <= start:
            raise broken_rule(f"must be greater than start, {start:g}")
        return stop

    @property
    def values(self) -> tuple[float, ...]:
        """All of them, increasing."""
        shares = [k / (self.count - 1) for k in range(1, self.count - 1)]
        if self.spacing == "log":
            inner = [self.start * (self.stop / self.start) ** share for share in shares]
        else:
            inner = [self.start + (self.stop - self.start) * share for share in shares]
        return (self.start, *inner, self.stop)


class MarkedPoint(Section):
    """A point to mark in the picture of a tongue."""

    f: Density = Field(title="area_fraction", description="its area fraction")
    aspect_ratio: Positive = Field(title="Delta", description="its aspect ratio L_y/L_x")
    label: Text = Field(default="", description="what to write beside it")


class Stability(Section):
    """Extended states whose critical aspect ratios are wanted."""

    L: Annotated[tuple[Positive, ...], AfterValidator(_some_distinct)] = Field(
        title="collisional_loss", description="collisional losses"
    )
    f: Annotated[tuple[Density, ...] | AreaFractions, ListOr(AreaFractions)] = Field(
        title="area_fraction", description="area fractions: a list, or a section with start, stop and count"
    )
    walls: Annotated[tuple[Annotated[Text, Among(STABILITY_WALLS)], ...], AfterValidator(_some_distinct)] = Field(
        default=("vibrating",), description="kinds of the wall at x=1"
    )
    waves: Annotated[tuple[Annotated[int, Strict(), Field(ge=1, le=16384)], ...], AfterValidator(_some_distinct)] = (
        Field(default=(1,), description="numbers m of half-waves across the box in y")
    )
    points: tuple[MarkedPoint, ...] = Field(default=(), description="points to mark in the picture of a single L")

    @field_validator("f")
    @classmethod
    def _check_f(cls, f: tuple[float, ...] | AreaFractions) -> tuple[float, ...] | AreaFractions:
        return f if isinstance(f, AreaFractions) else _some_distinct(f)

    @property
    def area_fractions(self) -> tuple[float, ...]:
        """All area fractions."""
        return self.f.values if isinstance(self.f, AreaFractions) else self.f


class StabilityDeck(Deck):
    """Critical aspect ratios of extended states, and the tongues in which they exist."""

    kind: Literal["stability"] = "stability"
    gas: DensityGas = DensityGas()
    stability: Stability


KINDS: dict[str, type[Deck]] = {
    "evolution": EvolutionDeck,
    "steady": SteadyDeck,
    "branch": BranchDeck,
    "stability": StabilityDeck,
}


def _same_length(values: tuple[float, ...], other: str, info: ValidationInfo) -> None:
    expected = len(info.data.get(other, values))
    if len(values) != expected:
        raise broken_rule(f"must have as many items as {other}, {expected}")


def kinds_of(model: type[Section], key: str) -> Mapping[str, type[Tagged]] | None:
    """The table of kinds when `key` of `model` is a tagged section, else None."""
    field = model.model_fields.get(key)
    markers = field.metadata if field else ()
    return next((marker.table for marker in markers if isinstance(marker, OneOf)), None)


def section_of(model: type[Section], key: str) -> type[Section] | None:
    """The model of the plain section `key` of `model`; None when it is no plain section."""
    field = model.model_fields.get(key)
    annotation = field.annotation if field and kinds_of(model, key) is None else None
    return annotation if isinstance(annotation, type) and issubclass(annotation, Section) else None


def list_or(model: type[Section], key: str) -> type[Section] | None:
    """The section as which `key` of `model`, else a list, may be given; None when there is none."""
    field = model.model_fields.get(key)
    return next((marker.section for marker in (field.metadata if field else ()) if isinstance(marker, ListOr)), None)


def item_of(model: type[Section], key: str) -> type[Section] | None:
    """The model of the items of `key` of `model`; None when it is no list of sections."""
    field = model.model_fields.get(key)
    parts = get_args(field.annotation) if field and get_origin(field.annotation) is tuple else ()
    return next((part for part in parts if isinstance(part, type) and issubclass(part, Section)), None)


def meaning(model: type[Section], key: str) -> str:
    """One line on `key` of `model`: its description, or that of the section that it is."""
    field = model.model_fields[key]
    return field.description or (getattr(field.annotation, "__doc__", None) or "").rstrip(".")
