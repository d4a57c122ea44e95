"""The state of a run: conserved fields on a mesh at a time, and what follows from them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hydro.errors import RunFailed
from hydro.fields import MX, MY, E, N
from hydro.gas import Closure
from hydro.mesh import Mesh


@dataclass
class State:
    """Conserved fields of a gas on a mesh.

    conserved: (4, nx, ny), density n, momenta n u and n v, energy e = n T + n v^2/2. time: scaled.
    gas: a closure with its constants. All scaled units; derived fields have shape (nx, ny).
    """

    gas: Closure
    mesh: Mesh
    conserved: np.ndarray
    time: float = 0.0

    @classmethod
    def of(cls, gas, mesh: Mesh, density, temperature, velocity=(0.0, 0.0), time: float = 0.0) -> State:
        """From density, temperature and velocity components, each a number or an array that fits (nx, ny)."""
        fields = (density, temperature, *velocity)
        n, T, u, v = (np.broadcast_to(np.asarray(field, float), mesh.cells) for field in fields)
        return cls(gas, mesh, np.array([n, n * u, n * v, n * T + 0.5 * n * (u * u + v * v)]), time)

    def copy(self) -> State:
        return State(self.gas, self.mesh, self.conserved.copy(), self.time)

    @property
    def density(self) -> np.ndarray:
        return self.conserved[N]

    @property
    def velocity(self) -> tuple[np.ndarray, np.ndarray]:
        return self.conserved[MX] / self.density, self.conserved[MY] / self.density

    @property
    def kinetic_energy(self) -> np.ndarray:
        """Energy of the flow per area."""
        return 0.5 * (self.conserved[MX] ** 2 + self.conserved[MY] ** 2) / self.density

    @property
    def temperature(self) -> np.ndarray:
        return (self.conserved[E] - self.kinetic_energy) / self.density

    @property
    def pressure(self) -> np.ndarray:
        return self.gas.pressure(self.density, self.temperature)

    @property
    def speed(self) -> np.ndarray:
        u, v = self.velocity
        return np.sqrt(u * u + v * v)

    @property
    def sound_speed(self) -> np.ndarray:
        return self.gas.sound_speed(self.density, self.temperature)

    @property
    def mach(self) -> np.ndarray:
        return self.speed / self.sound_speed

    @property
    def mass(self) -> float:
        return self.mesh.integral(self.density)

    @property
    def energy(self) -> float:
        return self.mesh.integral(self.conserved[E])


ROUND_OFF = 1e-14  # of the energy of the flow: heat that is less is not known


def inadmissible(state: State) -> np.ndarray:
    """Where n is not between 0 and that of packing, or T not positive beyond round-off, shape (nx, ny)."""
    with np.errstate(all="ignore"):
        n, T, flow = state.density, state.temperature, state.kinetic_energy
        cold = ~(n * T > ROUND_OFF * flow)
        return cold | ~((n > 0.0) & (n < state.gas.packing_density()) & np.isfinite(state.conserved).all(axis=0))


def refuse_inadmissible(state: State) -> None:
    """RunFailed for a state that is none of a gas, and so is not to be saved."""
    if inadmissible(state).any():
        raise RunFailed(f"the state at t = {state.time:.6g} is not saved: {worst_cell(state)}")


def worst_cell(state: State) -> str:
    """A sentence on the first cell that is out of bounds; without one, on that with the least share of heat."""
    where = np.argwhere(inadmissible(state))
    if not len(where):
        return coldest_cell(state)
    return f"{len(where)} cells would leave {bounds(state.gas)}, T > 0; {cell_words(state, *where[0])}"


def coldest_cell(state: State) -> str:
    """A sentence on the cell whose heat is the least share of its energy: round-off may decide about it."""
    shares = state.density * state.temperature / state.conserved[E]
    i, j = np.unravel_index(np.argmin(shares), shares.shape)
    return f"heat would be {shares[i, j]:.1e} of the energy where it is least; {cell_words(state, int(i), int(j))}"


def cell_words(state: State, i: int, j: int) -> str:
    """Where a cell is, and its density and temperature."""
    with np.errstate(all="ignore"):
        values = f"n = {state.density[i, j]:.4g}, T = {state.temperature[i, j]:.4g}"
    return f"cell ({i}, {j}) at x = {state.mesh.x[i]:.4g}, y = {state.mesh.y[j]:.4g} would get {values}"


def bounds(gas: Closure) -> str:
    """In which bounds densities of a gas lie, in words."""
    packed = gas.packing_density()
    return f"0 < n < {packed:g}" if packed < math.inf else "0 < n"
