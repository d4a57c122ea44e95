"""The steady state that a given state is near: on its mesh, and in the image that fits it best.

In a closed box a chain of clusters has two images: with the first cluster in the corner y = 0, and half a wave from it.
For an odd number of half-waves they are mirror images of each other. In a box that is periodic in y a chain can stand
anywhere: there the given state is moved to where the chain stands.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.fft import dct

from hydro.errors import RunFailed
from hydro.gas.packing import density_at, log_void
from hydro.mesh import Mesh
from hydro.state import State
from hydro.steady.balance import Balance
from hydro.steady.localized import SteadyState, chain, interpolated, steady_state, unit_cell
from hydro.steady.newton import solve

CANDIDATES = 3  # numbers of half-waves that are tried beside none, those that are strongest in the state
FEWEST = 4  # cells across a half-wave


@dataclass(frozen=True)
class Attempt:
    """A number of half-waves that was tried: distance of its state, or why there is none."""

    wave: int
    distance: float = np.inf
    reason: str = ""


def nearest(balance: Balance, state: State, waves: Iterable[int]) -> tuple[SteadyState, list[Attempt]]:
    """The steady state of `balance` nearest to `state`, among those with `waves` half-waves, and what was tried.

    RunFailed if none is found.
    """
    found: list[tuple[float, SteadyState]] = []
    tried = []
    for wave in waves:
        try:
            steady = steady_state(balance.gas, balance.wall, balance.mesh, balance.area_fraction, wave)
        except RunFailed as error:
            tried.append(Attempt(wave, reason=str(error).splitlines()[0].rstrip(":")))
            continue
        ranked = [(distance(state, image), image) for image in images(steady)]
        found.append(min(ranked, key=lambda pair: pair[0]))
        tried.append(Attempt(wave, found[-1][0]))
    if not found:
        raise RunFailed("no steady state found:\n  " + "\n  ".join(f"wave {a.wave}: {a.reason}" for a in tried))
    return min(found, key=lambda pair: pair[0])[1], tried


def candidates(state: State) -> list[int]:
    """Numbers of half-waves to try: none, and those strongest in log(1/n - 1/n_p) along the wall x = 0, if they fit."""
    mesh = state.mesh
    w = log_void(state.gas, state.density[0])
    strength = np.abs(dct(w))
    if mesh.periodic[1]:
        strength = np.zeros(mesh.cells[1])
        strength[::2] = np.abs(np.fft.rfft(w))[: strength[::2].size]
    fitting = [wave for wave in range(1, mesh.cells[1]) if fits(wave, mesh)]
    return [0, *sorted(fitting, key=lambda wave: -strength[wave])[:CANDIDATES]]


def fits(wave: int, mesh: Mesh) -> bool:
    """Whether a chain of `wave` half-waves can be on the mesh: cells in y a multiple, an even number if periodic."""
    if wave == 0:
        return True
    count, rest = divmod(mesh.cells[1], wave)
    return rest == 0 and count >= FEWEST and not (mesh.periodic[1] and wave % 2)


def carried(balance: Balance, steady: State, wave: int) -> SteadyState:
    """A steady state with `wave` half-waves, known on another mesh, solved for on that of `balance`, which it `fits`.

    NotConverged if there is none near it.
    """
    mesh = balance.mesh
    cell = unit_cell(mesh, wave)
    known = np.append(log_void(balance.gas, steady.density), np.log(steady.pressure.mean()))
    found = solve(balance.on(cell), interpolated(known, steady.mesh, cell))
    unknowns = chain(found.unknowns, cell, mesh, shifted=False)
    return SteadyState(balance, wave, unknowns, found.iterations, found.residual)


def images(steady: SteadyState) -> Iterator[SteadyState]:
    """The state, and in a closed box its other image: shifted by half a wave, which mirrors an odd chain."""
    yield steady
    mesh = steady.balance.mesh
    if steady.wave and not mesh.periodic[1]:
        w = steady.unknowns[:-1].reshape(mesh.cells)
        other = np.roll(w, mesh.cells[1] // steady.wave, axis=1) if steady.mirrored else w[:, ::-1]
        yield replace(steady, unknowns=np.append(other, steady.unknowns[-1]))


def distance(state: State, steady: SteadyState) -> float:
    """Root mean square difference of the densities, over that of the steady density."""
    there = steady.state
    density = aligned(state, steady)[0].density
    return float(np.sqrt(state.mesh.integral((density - there.density) ** 2) / state.mesh.integral(there.density**2)))


def aligned(state: State, steady: SteadyState) -> tuple[State, float]:
    """The state, moved along y to where the steady state stands if the box is periodic, and by how much."""
    mesh = state.mesh
    if not mesh.periodic[1] or steady.wave == 0:
        return state, 0.0
    shift = place(steady.state.density, mesh, steady.wave) - place(state.density, mesh, steady.wave)
    n = density_at(state.gas, translated(log_void(state.gas, state.density), mesh, shift))
    T = np.exp(translated(np.log(state.temperature), mesh, shift))
    velocity = tuple(translated(component, mesh, shift) for component in state.velocity)
    return State.of(state.gas, mesh, n, T, velocity, state.time), shift


def place(density: np.ndarray, mesh: Mesh, wave: int) -> float:
    """Where a chain in a periodic box has its first cluster: by the phase of its longest wave in y."""
    k = np.pi * wave / mesh.aspect_ratio
    return -float(np.angle(mesh.dx @ density @ np.exp(-1j * k * mesh.y))) / k


def translated(field: np.ndarray, mesh: Mesh, shift: float) -> np.ndarray:
    """A field (nx, ny), periodic in y, moved by `shift` along y, by its Fourier series."""
    k = 2.0 * np.pi * np.fft.rfftfreq(mesh.cells[1], mesh.aspect_ratio / mesh.cells[1])
    return np.fft.irfft(np.fft.rfft(field, axis=1) * np.exp(-1j * k * shift), n=mesh.cells[1], axis=1)
