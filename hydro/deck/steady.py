"""`kind = "steady"` and `kind = "branch"`: steady states in two dimensions, one by one or along a parameter."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, Strict, ValidationInfo, field_validator

from hydro.choices import CLOSURES, PARAMETERS, SEARCHES, WALL_CONDITIONS, WALLS
from hydro.deck.sections import ClosedBox, ExperimentDeck, Mesh, ViscousGas
from hydro.schema import (
    Chosen,
    Flag,
    HalfWaves,
    Named,
    Number,
    Positive,
    Section,
    Text,
    Wave,
    broken_rule,
    unknown_choice,
)


class SteadyGas(ViscousGas):
    """The granular gas. Densities of steady states know only L and f; growth rates also K, tau and viscosity."""

    L: Positive = Field(title="collisional_loss", description="collisional loss, (32/(3 gamma)) (L_x/d)^2 (1-r^2)")
    f: Positive = Field(title="area_fraction", description="average area fraction n/n_c")
    K: Positive = Field(default=2e-3, title="conduction", description="heat conduction, mu d/L_x")
    tau: Positive = Field(
        default=200.0,
        allow_inf_nan=True,
        title="friction_time",
        description="time in which rolling friction stops the flow, in L_x/T_*^(1/2); inf for none",
    )


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
    search: Annotated[Text, Named(SEARCHES)] = Field(
        default="relaxation",
        description="how to find it: relaxation of a gas pushed to one side, which ends in a stable half-wave; "
        "branch: the first state on the branch from the nearest bifurcation in f, unstable beyond a subcritical one",
    )
    modes: Annotated[int, Strict(), Field(ge=1, le=16)] = Field(
        default=3,
        description="number of leading eigenmodes to keep in each symmetry sector, those of largest growth rate; "
        "a pair that oscillates counts as one",
    )
    mode_amplitude: Number = Field(
        default=1e-3,
        gt=0,
        lt=0.5,
        description="largest relative change of the density, or largest Mach number if that is more, "
        "in the checkpoints of the state plus an eigenmode",
    )


class SteadyBaseDeck(ExperimentDeck):
    """What decks of steady states have in common."""

    gas: Annotated[SteadyGas, Chosen(CLOSURES, key="closure", shared=SteadyGas)]
    box: ClosedBox = ClosedBox()
    mesh: Mesh
    wall: Annotated[Any, Chosen(WALLS, only=tuple(WALL_CONDITIONS))] = Field(
        default={"kind": "vibrating"}, description="The wall at x=1. Steady densities do not depend on W"
    )

    @field_validator("wall")
    @classmethod
    def _check_wall(cls, wall: Any) -> Any:
        if getattr(wall, "W", 1.0) == 0.0:
            raise broken_rule("must be greater than 0", "wall.W", 0)
        return wall

    @property
    def damping(self) -> str:
        """What growth rates depend on, and what of it the deck does not give, in words."""
        gas = self.gas
        values = {"gas.K": gas.K, "gas.tau": gas.tau, "gas.viscosity": gas.viscosity}
        if hasattr(self.wall, "W"):
            values["wall.W"] = self.wall.W
        words = "growth rates per unit of time, L_x/T_*^(1/2), for "
        words += ", ".join(f"{key.partition('.')[2]} = {value:g}" for key, value in values.items())
        assumed = ", ".join(f"{key} = {value:g}" for key, value in self.assumed.items())
        return f"{words}; not in the deck, and assumed: {assumed}" if assumed else words

    @property
    def assumed(self) -> dict[str, float]:
        """What growth rates depend on and the deck does not give, with the values that are taken instead."""
        wanted = [("gas", "K"), ("gas", "tau"), ("wall", "W")]
        sections = [(f"{name}.{key}", key, getattr(self, name)) for name, key in wanted]
        return {
            dotted: getattr(section, key)
            for dotted, key, section in sections
            if hasattr(section, key) and key not in section.model_fields_set
        }


class SteadyDeck(SteadyBaseDeck):
    """A steady state in two dimensions, on the finite volumes of the evolution, and its growth rates."""

    scalars: ClassVar[tuple[str, ...]] = (
        "wall_max", "wall_min", "growth_rate", "stable", "gas_density", "pressure", "residual", "wall_seconds",
    )  # fmt: skip

    kind: Literal["steady"] = "steady"
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
    f: Positive | None = Field(  # type: ignore[assignment]
        default=None, title="area_fraction", description="average area fraction; required unless it is the parameter"
    )


class Branch(Section):
    """Which branch: where it leaves the extended state, and how far to follow it."""

    parameter: Text = Field(
        default="f",
        description="what changes along the branch: f, aspect_ratio, or a constant of the closure that allows it, L",
    )
    wave: HalfWaves = Field(default=1, description="number of half-waves across the box in y")
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


class BranchDeck(SteadyBaseDeck):
    """Branches of localized states, from where they leave the extended state, through folds, to the end of a range."""

    scalars: ClassVar[tuple[str, ...]] = (
        "first_bifurcation", "last_bifurcation", "first_fold", "last_fold", "wall_seconds",
    )  # fmt: skip

    kind: Literal["branch"] = "branch"
    gas: Annotated[BranchGas, Chosen(CLOSURES, key="closure", shared=BranchGas)] = Field(default={})  # type: ignore[assignment]
    branch: Branch

    @field_validator("branch")
    @classmethod
    def _check_branch(cls, branch: Branch, info: ValidationInfo) -> Branch:
        gas = info.data.get("gas")
        known = (*PARAMETERS, *(() if gas is None else gas.law().parameters()))
        if gas is not None and branch.parameter not in known:
            raise unknown_choice(branch.parameter, known, "parameter")
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
