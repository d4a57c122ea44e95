"""Exact evolutions that decks ask for, by the kind of their initial state."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from hydro.dynamics.integrator import Source
from hydro.exact.manufactured import Manufactured
from hydro.exact.solutions import (
    LINEAR_MODES,
    DensityWave,
    SimpleWave,
    cell_averages,
    homogeneous_cooling,
    linear_modes,
)
from hydro.mesh import Mesh
from hydro.registry import Registry
from hydro.setup import gas_of
from hydro.state import State

# Conserved fields, shape (4, nx, ny), averaged over the cells of a mesh, at a time.
Evolution = Callable[[Mesh, float], np.ndarray]

EVOLUTIONS: Registry[Callable[[Any], Evolution]] = Registry("exact evolution")  # of evolution decks
SOURCES: dict[str, Callable[[Any], Source]] = {}  # for evolutions that need a source to be one


def exact_evolution(deck: Any) -> Evolution:
    """The evolution from the deck's initial state; exact under conditions that `hydro.deck.campaigns` knows."""
    return EVOLUTIONS[deck.initial.kind](deck)


def source_of(deck: Any) -> Source | None:
    """What the deck's initial state wants to be added to the equations, if anything."""
    source = SOURCES.get(deck.initial.kind)
    return source(deck) if source else None


@EVOLUTIONS.register("uniform")
def cooling(deck: Any) -> Evolution:
    """Homogeneous cooling of a gas that moves as a whole, if at all, and is slowed down by friction."""
    gas, n, initial = gas_of(deck), deck.gas.f, deck.initial

    def conserved(mesh: Mesh, t: float) -> np.ndarray:
        T, keep = homogeneous_cooling(gas, n, initial.temperature, t), np.exp(-t / deck.gas.tau)
        return State.of(gas, mesh, n, T, (keep * initial.velocity[0], keep * initial.velocity[1])).conserved

    return conserved


@EVOLUTIONS.register("simple_wave")
def simple_wave(deck: Any) -> Evolution:
    """Sound of finite amplitude."""
    return along_x(SimpleWave(gas_of(deck), deck.gas.f, deck.initial.temperature, deck.initial.amplitude).conserved)


@EVOLUTIONS.register("density_wave")
def density_wave(deck: Any) -> Evolution:
    """Density carried along at uniform pressure."""
    gas, n, initial = gas_of(deck), deck.gas.f, deck.initial
    pressure = float(gas.pressure(n, initial.temperature))
    return along_x(DensityWave(gas, n, initial.amplitude, pressure, initial.velocity).conserved)


@EVOLUTIONS.register("eigenmode")
def eigenmode(deck: Any) -> Evolution:
    """A uniform gas at rest and a small mode of the linearized equations."""
    gas, n, T = gas_of(deck), deck.gas.f, deck.initial.temperature
    mode = LINEAR_MODES[deck.initial.mode](linear_modes(gas, n, T, deck.gas.tau, 2.0 * np.pi))

    def conserved(x: np.ndarray, t: float) -> np.ndarray:
        dn, du, dT = deck.initial.amplitude * n * mode.fields(x, t)
        return np.stack([n + dn, (n + dn) * du, (n + dn) * (T + dT + 0.5 * du * du)])

    return along_x(conserved)


@EVOLUTIONS.register("manufactured")
def made_up(deck: Any) -> Evolution:
    """The made-up solution."""
    return manufactured(deck).conserved


def manufactured(deck: Any) -> Manufactured:
    """The made-up solution in the deck's box."""
    return Manufactured(gas_of(deck), deck.gas.tau, getattr(deck.wall, "W", 0.0), deck.box.aspect_ratio)


SOURCES["manufactured"] = lambda deck: manufactured(deck).source


def along_x(conserved: Callable[[np.ndarray, float], np.ndarray]) -> Evolution:
    """The evolution of (n, n u, e)(x, t): averaged over cells, with nothing that moves along y."""

    def averages(mesh: Mesh, t: float) -> np.ndarray:
        n, momentum, e = cell_averages(lambda x: conserved(x, t), mesh.x_faces)
        line = np.stack([n, momentum, 0.0 * n, e])
        return np.repeat(line[:, :, None], mesh.cells[1], axis=2)

    return averages
