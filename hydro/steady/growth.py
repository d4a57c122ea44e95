"""Growth rates of a steady state in its whole box, symmetry by symmetry.

A state that is its own mirror image about the middle of the box in y has symmetric and antisymmetric modes, found on
half of the box. The modes of the extended state are cosines in y, one wave number after the other. Other states have
one sector: all perturbations. In a box that is periodic in y the corner y = 0 is a mirror too, so that antisymmetric
modes, that of a motion along y among them, vanish on both sides of the half; and waves have even numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from scipy import fft

from hydro.initial.cosine import cosine_averages, sine_averages
from hydro.initial.regrid import regrid
from hydro.mesh import Mesh
from hydro.state import State
from hydro.steady.localized import SteadyState, ladder, unit_cell
from hydro.steady.spectrum import MODES, Linearization, Linearized, Mode, Sector, even, odd, wave_sector
from hydro.steady.viscous import ViscousLinearization

Change = Callable[[np.ndarray], np.ndarray]

SPARE = 3  # more modes than wanted that are looked for on a coarse mesh
DECLINES = 2  # wave numbers of smaller growth rate in a row, after which shorter waves are not looked at


@dataclass(frozen=True, eq=False)
class Growth:
    """The leading modes of one symmetry sector, those of largest growth rate first; fields on the whole box."""

    sector: str
    modes: list[Mode]

    @property
    def rate(self) -> float:
        """The largest growth rate, per unit time; minus infinity if no mode was found."""
        return max((mode.growth_rate.real for mode in self.modes), default=-np.inf)


@dataclass(frozen=True)
class Damping:
    """What brakes the flow."""

    tau: float
    viscosity: float


def growth_of(steady: SteadyState, tau: float, count: int = MODES, viscosity: float = 0.0) -> list[Growth]:
    """Growth in every sector of the whole box; `count` modes in each. RunFailed if they are not found.

    tau: friction time. viscosity: over that of the closure.
    """
    sectors = extended_sectors if steady.wave == 0 else mirror_sectors if steady.mirrored else whole_sector
    return list(sectors(steady, Damping(tau, viscosity), count))


def linearized(state: State, wall: Any, damping: Damping, sector: Sector) -> Linearized:
    """The equations linearized about a state, of a viscous gas or of one without viscosity."""
    if damping.viscosity > 0.0:
        return ViscousLinearization(state, wall, damping.tau, sector, damping.viscosity)
    return Linearization(state, wall, damping.tau, sector)


def leading(state: State, wall: Any, damping: Damping, sector_on: Callable[[Mesh], Sector], count: int) -> list[Mode]:
    """The `count` modes of largest growth rate in the sector that `sector_on` gives for a mesh.

    Oscillations are looked for on a coarse mesh, where that is cheap, and found again on that of the state.
    """
    whole, mesh = linearized(state, wall, damping, sector_on(state.mesh)), ladder(state.mesh)[0]
    if mesh is state.mesh:
        return whole.leading(count)
    rough = linearized(regrid(state, mesh), wall, damping, sector_on(mesh))
    return whole.leading(count, [mode.growth_rate for mode in rough.leading(count + SPARE)])


def growth_rate(growths: list[Growth]) -> float:
    """The largest of all sectors."""
    return max(growth.rate for growth in growths)


def whole_sector(steady: SteadyState, damping: Damping, count: int) -> Iterator[Growth]:
    """All perturbations."""
    name = "all"
    modes = leading(steady.state, steady.balance.wall, damping, lambda mesh: replace(even(mesh), name=name), count)
    yield Growth(name, modes)


def mirror_sectors(steady: SteadyState, damping: Damping, count: int) -> Iterator[Growth]:
    """Perturbations that are even, and odd, about the middle of the box."""
    state, wall = steady.state, steady.balance.wall
    half = lower_half(state)
    mirrors = (0, -1) if state.mesh.periodic[1] else (-1,)
    for sector_on, parity in ((even, 1.0), (partial(odd, sides=mirrors), -1.0)):
        modes = leading(half, wall, damping, sector_on, count)
        along, across = partial(unfolded, parity=parity), partial(unfolded, parity=-parity)
        yield Growth(sector_on(half.mesh).name, [mapped(mode, along, across) for mode in modes])


def extended_sectors(steady: SteadyState, damping: Damping, count: int) -> Iterator[Growth]:
    """Perturbations with 0, 1, 2 ... half-waves in y, until their growth rates have begun to fall."""
    mesh, wall = steady.balance.mesh, steady.balance.wall
    line = first_column(steady.state)
    rates: list[float] = []
    for wave in waves_on(mesh):
        sector = wave_sector(line.mesh, mesh.cells[1], mesh.aspect_ratio, wave)
        modes = linearized(line, wall, damping, sector).leading(count)
        along, across = (partial(np.multiply, shape(mesh, wave)) for shape in (cosine_averages, sine_averages))
        found = Growth(sector.name, [mapped(mode, along, across) for mode in modes])
        yield found
        rates.append(found.rate)
        if len(rates) > DECLINES + 1 and all(np.diff(rates[-DECLINES - 1 :]) < 0.0):
            return


def waves_on(mesh: Mesh) -> range:
    """Numbers of half-waves in y that a perturbation may have."""
    return range(0, mesh.cells[1] + 1, 2) if mesh.periodic[1] else range(mesh.cells[1])


def sector_parts(steady: SteadyState, field: np.ndarray) -> Iterator[np.ndarray]:
    """The part of a field (nx, ny) in every symmetry sector, in the order of `growth_of`."""
    mesh = steady.balance.mesh
    if steady.wave == 0:
        yield from (wave_part(field, mesh, wave) for wave in waves_on(mesh))
    elif steady.mirrored:
        yield from (0.5 * (field + field[:, ::-1]), 0.5 * (field - field[:, ::-1]))
    else:
        yield field


def wave_part(field: np.ndarray, mesh: Mesh, wave: int) -> np.ndarray:
    """The part of a field with `wave` half-waves in y; in a periodic box whether cosine or sine."""
    forward, backward, number = (fft.rfft, fft.irfft, wave // 2) if mesh.periodic[1] else (fft.dct, fft.idct, wave)
    spectrum = forward(field, axis=1)
    kept = np.zeros_like(spectrum)
    kept[:, number] = spectrum[:, number]
    return backward(kept, n=mesh.cells[1], axis=1)


def lower_half(state: State) -> State:
    """The half of the box next to y = 0."""
    count = state.mesh.cells[1] // 2
    mesh = Mesh(state.mesh.x_faces, state.mesh.y_faces[: count + 1])
    return State(state.gas, mesh, np.ascontiguousarray(state.conserved[:, :, :count]))


def first_column(state: State) -> State:
    """A state uniform in y, on a mesh of one cell there."""
    return State(state.gas, unit_cell(state.mesh, 0), np.ascontiguousarray(state.conserved[:, :, :1]))


def unfolded(field: np.ndarray, parity: float) -> np.ndarray:
    """A field on half of the box with its mirror image."""
    return np.concatenate([field, parity * field[:, ::-1]], axis=1)


def mapped(mode: Mode, along: Change, across: Change) -> Mode:
    """The mode on the whole box, by a change of its fields; `across` is that of the momentum in y."""
    density, temperature, momentum_x = (along(field) for field in (mode.density, mode.temperature, mode.momentum_x))
    return Mode(mode.growth_rate, mode.sector, density, temperature, momentum_x, across(mode.momentum_y))


def size(state: State, mode: Mode) -> float:
    """The largest relative change of density by a mode, or the largest Mach number if that is more."""
    speed = np.hypot(mode.momentum_x.real, mode.momentum_y.real) / state.density
    changes = np.abs(mode.density.real) / state.density
    return float(max(np.max(changes), np.max(speed / state.sound_speed)))


def with_mode(state: State, mode: Mode, amplitude: float) -> State:
    """The state plus the real part of a mode of the size `amplitude`."""
    scale = amplitude / size(state, mode)
    n, T = state.density + scale * mode.density.real, state.temperature + scale * mode.temperature.real
    momentum_x, momentum_y = scale * mode.momentum_x.real, scale * mode.momentum_y.real
    return State.of(state.gas, state.mesh, n, T, (momentum_x / n, momentum_y / n))
