"""Profiles along one coordinate."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, ValidationInfo, field_validator

from hydro.initial.state import InitialState
from hydro.mesh import Mesh
from hydro.schema import Axis, Density, Increasing, Number, Positive, broken_rule, same_length
from hydro.state import State


class Profile(InitialState):
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

    def state(self, deck: Any, gas: Any, mesh: Mesh) -> State:
        """Profiles taken at cell centres."""
        centres = mesh.x if self.axis == "x" else mesh.y

        def field(values):
            return np.interp(centres, self.positions, values or np.zeros(len(self.positions)))

        density = field(self.density)
        T = field(self.temperature) if self.temperature else gas.temperature(density, field(self.pressure))
        velocity = [along(self.axis, field(values)) for values in (self.velocity, self.transverse_velocity)]
        components = velocity if self.axis == "x" else velocity[::-1]
        return State.of(gas, mesh, along(self.axis, density), along(self.axis, T), tuple(components))


def along(axis: str, values: np.ndarray) -> np.ndarray:
    """Values along one axis, shaped to be broadcast over the mesh."""
    return values[:, None] if axis == "x" else values[None, :]
