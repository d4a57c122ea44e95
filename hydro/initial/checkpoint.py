"""The state of a checkpoint."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from hydro.choices import PATTERNS
from hydro.errors import CheckpointError, Complaint, DeckError
from hydro.initial.regrid import regrid
from hydro.initial.state import InitialState
from hydro.mesh import Mesh
from hydro.schema import Chosen, FileName, Flag
from hydro.state import State, inadmissible


class FromCheckpoint(InitialState):
    """The state of a checkpoint, perturbed or as it is."""

    kind: Literal["checkpoint"] = "checkpoint"
    path: FileName = Field(description="checkpoint file (.h5)")
    refill: Flag = Field(
        default=False,
        description="whether to add or take grains until the mean density is gas.f: everywhere by one factor on "
        "n/(1-n), at the same temperature and velocity; pressure then stays about uniform",
    )
    perturbation: Annotated[Any | None, Chosen(PATTERNS)] = Field(
        default=None, description="relative change of the density; none when not given"
    )

    @property
    def needs_area_fraction(self) -> bool:
        return self.refill

    def state(self, deck: Any, gas: Any, mesh: Mesh) -> State:
        """The state, of grains the average over their looks, on this mesh, with a perturbation or none."""
        from hydro.output.checkpoint import averaged  # h5py is slow to import

        saved = checkpoint_of(deck)
        state = regrid(State(gas, saved.mesh, averaged(saved)), mesh)
        if self.refill and not inadmissible(state).any():  # else it is refused, for what it is
            state = refilled(state, deck.gas.f)
        return state if self.perturbation is None else perturbed(state, self.perturbation.values(mesh))


def checkpoint_of(deck: Any) -> Any:
    """The checkpoint that a deck starts from; DeckError if it cannot be read, or is of another box."""
    from hydro.output.checkpoint import read_checkpoint

    initial = deck.initial
    try:
        saved = read_checkpoint(Path(initial.path))
    except CheckpointError as error:
        raise DeckError([Complaint("initial.path", str(error))], "initial state") from error
    if not np.isclose(saved.mesh.aspect_ratio, deck.box.aspect_ratio, rtol=1e-12):
        problem = f"{initial.path} has the aspect ratio {saved.mesh.aspect_ratio:g}, box.aspect_ratio is another"
        raise DeckError([Complaint("initial.path", problem)], "initial state")
    return saved


def refilled(state: State, mean: float) -> State:
    """The state with the mean density `mean`: n/(1-n/n_p) times a common factor, at the same temperature and velocity.

    No density comes to that of packing, n_p. The pressure, like n/(1-n/n_p) in dilute and in dense gas, changes by
    about that factor.
    """
    from scipy.optimize import brentq  # slow to import

    gas, mesh = state.gas, state.mesh
    odds, wanted = (n / gas.gap(n) for n in (state.density, mean))

    def filled(log_factor: float) -> np.ndarray:
        changed = odds * math.exp(log_factor)
        return changed / (1.0 + changed / gas.packing_density())

    def excess(log_factor: float) -> float:
        return mesh.integral(filled(log_factor)) - mean * mesh.aspect_ratio

    bounds = (math.log(wanted / odds.max()), math.log(wanted / odds.min()))  # where n is below, and above, everywhere
    density = filled(brentq(excess, bounds[0] - 1e-9, bounds[1] + 1e-9, xtol=1e-14))
    return State.of(gas, mesh, density, state.temperature, state.velocity, state.time)


def perturbed(state: State, pattern: np.ndarray) -> State:
    """Density times (1 + pattern), the mass kept, at the same temperature and velocity."""
    density = state.density * (1.0 + pattern)
    density *= state.mass / state.mesh.integral(density)
    return State.of(state.gas, state.mesh, density, state.temperature, state.velocity, state.time)
