"""Growth rates of a steady state in its whole box, symmetry by symmetry.

A state that is its own mirror image about the middle of the box in y has symmetric and antisymmetric modes, found on
half of the box. The modes of the extended state are cosines in y, one wave number after the other. Other states have
one sector: all perturbations. In a box that is periodic in y the corner y = 0 is a mirror too, so that antisymmetric
modes, that of a motion along y among them, vanish on both sides of the half; and waves have even numbers.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy import fft

from hydro.initial.cosine import cosine_averages
from hydro.mesh import Mesh
from hydro.state import State
from hydro.steady.localized import SteadyState, unit_cell
from hydro.steady.spectrum import Linearization, Mode, even, odd, wave_sector

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


def growth_of(steady: SteadyState, tau: float, count: int = 3) -> list[Growth]:
    """Growth in every sector of the whole box; `count` modes in each."""
    sectors = extended_sectors if steady.wave == 0 else mirror_sectors if steady.mirrored else whole_sector
    return [Growth(found.sector, found.modes[:count]) for found in sectors(steady, tau)]


def growth_rate(growths: list[Growth]) -> float:
    """The largest of all sectors."""
    return max(growth.rate for growth in growths)


def whole_sector(steady: SteadyState, tau: float) -> Iterator[Growth]:
    """All perturbations."""
    balance = steady.balance
    sector = replace(even(balance.mesh), name="all")
    modes = Linearization(steady.state, balance.wall, tau, sector, balance.faces).leading()
    yield Growth(sector.name, modes)


def mirror_sectors(steady: SteadyState, tau: float) -> Iterator[Growth]:
    """Perturbations that are even, and odd, about the middle of the box."""
    state, wall = steady.state, steady.balance.wall
    half = lower_half(state)
    mirrors = (0, -1) if state.mesh.periodic[1] else (-1,)
    for sector, parity in ((even(half.mesh), 1.0), (odd(half.mesh, mirrors), -1.0)):
        modes = Linearization(half, wall, tau, sector).leading()
        yield Growth(sector.name, [mapped(mode, lambda field: unfolded(field, parity)) for mode in modes])  # noqa: B023


def extended_sectors(steady: SteadyState, tau: float) -> Iterator[Growth]:
    """Perturbations with 0, 1, 2 ... half-waves in y, until their growth rates have begun to fall."""
    mesh, wall = steady.balance.mesh, steady.balance.wall
    line = first_column(steady.state)
    rates: list[float] = []
    for wave in waves_on(mesh):
        sector = wave_sector(line.mesh, mesh.cells[1], mesh.aspect_ratio, wave)
        modes = Linearization(line, wall, tau, sector).leading()
        shape = cosine_averages(mesh, wave)
        found = Growth(sector.name, [mapped(mode, lambda field: field * shape) for mode in modes])  # noqa: B023
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


def mapped(mode: Mode, change: Any) -> Mode:
    """The mode with its fields changed."""
    fields = (change(field) for field in (mode.density, mode.temperature, mode.potential))
    return Mode(mode.growth_rate, mode.sector, *fields)


def with_mode(state: State, mode: Mode, amplitude: float) -> State:
    """The state plus the real part of a mode whose largest relative change of density is `amplitude`."""
    scale = amplitude / float(np.max(np.abs(mode.density.real) / state.density))
    n, T = state.density + scale * mode.density.real, state.temperature + scale * mode.temperature.real
    psi = scale * mode.potential.real
    momentum_x, momentum_y = (-slope for slope in gradient(psi, state.mesh))
    return State.of(state.gas, state.mesh, n, T, (momentum_x / n, momentum_y / n))


def gradient(field: np.ndarray, mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """Slopes at cell centres of a field that is even about all walls: means of those at the two faces."""
    slopes = []
    for axis, centres in enumerate((mesh.x, mesh.y)):
        lines = np.moveaxis(field, axis, -1)
        faces = np.diff(lines, axis=-1) / np.diff(centres)
        closed = np.concatenate([np.zeros_like(lines[..., :1]), faces, np.zeros_like(lines[..., :1])], axis=-1)
        slopes.append(np.moveaxis(0.5 * (closed[..., 1:] + closed[..., :-1]), -1, axis))
    return slopes[0], slopes[1]
