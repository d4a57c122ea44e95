"""The observables of a periodic gas that cools freely: how cold it is, how it flows, and on what lengths."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from hydro.mesh import Mesh
from hydro.observables.general import extended, temperature
from hydro.observables.sets import Curve, Panel, Quantity
from hydro.state import State

LEAST = 1e-13  # spread that is more than round-off


def cools_freely(deck: Any) -> bool:
    """Whether the gas of a deck is periodic in both directions, on even cells, and cools."""
    gas, mesh = deck.gas, getattr(deck, "mesh", None)
    periodic = {"x", "y"} == set(getattr(getattr(deck, "box", None), "periodic", ()))
    cools = (getattr(gas, "L", None) or 0.0) * (getattr(gas, "K", None) or 0.0) > 0.0
    return periodic and mesh is not None and mesh.stretch == 1.0 and cools


class Structure(NamedTuple):
    """Structure factors: power of Fourier modes, averaged over all wave vectors of about the same length.

    wave_numbers: (m,), middles of shells, multiples of the least one of the box, in 1/L_x. density: of n over its mean.
    across, along: of the velocity at right angles to the wave vector (vortices) and along it, over the mean T.
    """

    wave_numbers: np.ndarray
    density: np.ndarray
    across: np.ndarray
    along: np.ndarray


def structure(state: State) -> Structure:
    """The structure factors of a state on even cells, periodic in both directions; empty cells are at rest."""
    mesh, n = state.mesh, state.density
    k_x, k_y = wave_vectors(mesh)
    length, least = np.hypot(k_x, k_y), 2.0 * math.pi / max(1.0, mesh.aspect_ratio)
    shell = np.rint(length / least).astype(int)
    there = np.where(n > 0.0, n, np.inf)
    scale = math.sqrt(mean_temperature(state, None)) * n.size
    u, v = (np.fft.fft2(momentum / there) / scale for momentum in state.conserved[1:3])
    over = 1.0 / np.where(length > 0.0, length, np.inf)
    powers = (np.fft.fft2(n) / n.sum(), (k_x * v - k_y * u) * over, (k_x * u + k_y * v) * over)
    last = int(min(mesh.cells[0] // 2, mesh.cells[1] // 2 / mesh.aspect_ratio) * 2.0 * math.pi / least)
    counts = np.bincount(shell.ravel())[1 : last + 1]
    means = (np.bincount(shell.ravel(), (abs(each) ** 2).ravel())[1 : last + 1] / counts for each in powers)
    return Structure(least * np.arange(1, last + 1), *means)


def wave_vectors(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """Components of the wave vectors of `numpy.fft.fft2`, shapes (nx, 1) and (1, ny)."""
    widths = (mesh.dx, mesh.dy)
    k_x, k_y = (
        2.0 * math.pi * np.fft.fftfreq(count, width[0]) for count, width in zip(mesh.cells, widths, strict=True)
    )
    return k_x[:, None], k_y[None, :]


def mean_temperature(state: State, wall: Any) -> float:
    """Of the grains: thermal energy over mass."""
    return state.mesh.integral(state.density * temperature(state.conserved)) / state.mass


def kinetic_share(state: State, wall: Any) -> float:
    """Energy of the flow over all."""
    return 1.0 - state.mass * mean_temperature(state, wall) / state.energy


def enstrophy(state: State, wall: Any) -> float:
    """Half the mean square of the vorticity."""
    return 0.5 * float(np.mean(vorticity(state) ** 2))


def vorticity(state: State) -> np.ndarray:
    """dv/dx - du/dy by central differences across the sides, (nx, ny); empty cells are at rest."""
    there, mesh = np.where(state.density > 0.0, state.density, np.inf), state.mesh
    u, v = (momentum / there for momentum in state.conserved[1:3])
    v_x = (np.roll(v, -1, 0) - np.roll(v, 1, 0)) / (2.0 * mesh.dx[:, None])
    u_y = (np.roll(u, -1, 1) - np.roll(u, 1, 1)) / (2.0 * mesh.dy)
    return v_x - u_y


def density_spread(state: State, wall: Any) -> float:
    """Root mean square of n over its mean, less one; zero where that is round-off."""
    spread = float(np.std(state.density) / np.mean(state.density))
    return spread if spread > LEAST else 0.0


def density_peak(state: State, wall: Any) -> float:
    """Wave number of the largest structure factor of the density."""
    found = structure(state)
    return float(found.wave_numbers[np.argmax(found.density)])


def velocity_peak(state: State, wall: Any) -> float:
    """Wave number of the largest structure factor of the velocity."""
    found = structure(state)
    return float(found.wave_numbers[np.argmax(found.across + found.along)])


MEAN_TEMPERATURE = Quantity("mean_temperature", "mean temperature of the grains", "T_*", mean_temperature, "mean T")
KINETIC_SHARE = Quantity("kinetic_share", "share of the flow in the energy", "1", kinetic_share, "flow's share")
ENSTROPHY = Quantity("enstrophy", "half the mean square vorticity", "T_*/L_x^2", enstrophy, "enstrophy")
SPREAD = Quantity("density_spread", "spread of the density over its mean", "1", density_spread, "spread of n")
DENSITY_PEAK = Quantity("density_peak", "wave number at which the density varies most", "1/L_x", density_peak, "k of n")
VELOCITY_PEAK = Quantity(
    "velocity_peak", "wave number at which the velocity varies most", "1/L_x", velocity_peak, "k of v"
)

COOLING = extended(
    "cooling",
    fits=cools_freely,
    summary=(MEAN_TEMPERATURE, KINETIC_SHARE, ENSTROPHY, SPREAD, DENSITY_PEAK, VELOCITY_PEAK),
    estimated=(MEAN_TEMPERATURE, KINETIC_SHARE, SPREAD),
    closing=(
        ("mean_temperature", "mean T", ".3g"),
        ("kinetic_share", "flow's share", ".3f"),
        ("density_spread", "spread of n", ".3g"),
    ),
    compared=(MEAN_TEMPERATURE, KINETIC_SHARE, ENSTROPHY, SPREAD),
    panels=(
        Panel("The mean temperature", "mean $T/T_*$", (Curve("mean_temperature"),)),
        Panel(
            "Shares and spreads",
            "share, spread",
            (Curve("kinetic_share", "flow in the energy"), Curve("density_spread", "of $n$ over its mean", "--")),
        ),
        Panel(
            "Wave numbers",
            "$kL_x$ of the largest",
            (Curve("density_peak", "of density"), Curve("velocity_peak", "of velocity", "--")),
        ),
        Panel("Collisions", "collisions per grain", (Curve("collisions_per_grain"),)),
    ),
    overlaid=(
        Panel("The mean temperature", "mean $T/T_*$", (Curve("mean_temperature"),)),
        Panel("The spread of the density", "spread of $n$", (Curve("density_spread"),)),
        Panel("Collisions", "collisions\nper grain", (Curve("collisions_per_grain"),)),
    ),
    drawn=("structure", "vorticity"),
)
