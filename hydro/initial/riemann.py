"""Two states with a jump between them."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from pydantic import Field

from hydro.initial.profile import along
from hydro.initial.state import InitialState
from hydro.mesh import Mesh
from hydro.schema import Axis, Number, Primitive
from hydro.state import State


class Riemann(InitialState):
    """Two uniform states [n, u, p] with a jump between them; u is the velocity along the axis."""

    kind: Literal["riemann"] = "riemann"
    axis: Axis = Field(default="x", description="direction across the jump")
    position: Number = Field(
        default=0.5, gt=0, lt=1, description="place of the jump, as a fraction of the box along the axis"
    )
    left: Primitive = Field(description="[n, u, p] below the jump; 0 < n < 1, p > 0")
    right: Primitive = Field(description="[n, u, p] above the jump; 0 < n < 1, p > 0")

    def state(self, deck: Any, gas: Any, mesh: Mesh) -> State:
        """The cell that the jump crosses gets the average of the conserved quantities of both sides."""
        faces = mesh.x_faces if self.axis == "x" else mesh.y_faces
        share = np.clip((self.position * faces[-1] - faces[:-1]) / np.diff(faces), 0.0, 1.0)
        left, right = (_conserved_along(gas, mesh, self.axis, side) for side in (self.left, self.right))
        return State(gas, mesh, right + (left - right) * along(self.axis, share))


def _conserved_along(gas, mesh: Mesh, axis: str, primitive) -> np.ndarray:
    n, speed, p = primitive
    velocity = (speed, 0.0) if axis == "x" else (0.0, speed)
    return State.of(gas, mesh, n, gas.temperature(n, p), velocity).conserved
