"""Exact evolutions that decks ask for, by the kind of their initial state."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from hydro.exact.manufactured import Manufactured
from hydro.exact.solutions import (
    DensityWave,
    SimpleWave,
    cell_averages,
    homogeneous_cooling,
    linear_modes,
)
from hydro.mesh import Mesh
from hydro.registry import Registry
from hydro.setup import gas_of, viscosity_of, wall_of
from hydro.state import State
from hydro.terms import Source

# Conserved fields, shape (4, nx, ny), averaged over the cells of a mesh, at a time.
Evolution = Callable[[Mesh, float], np.ndarray]

EVOLUTIONS: Registry[Callable[[Any], Evolution]] = Registry("exact evolution")  # of evolution decks
SOURCES: dict[str, Callable[[Any], Source]] = {}  # terms that an evolution needs to be exact


def exact_evolution(deck: Any) -> Evolution:
    """The evolution from the deck's initial state; exact under conditions that `hydro.deck.campaigns` knows."""
    return EVOLUTIONS[deck.initial.kind](deck)


def sources_of(deck: Any) -> list[Source]:
    """What the deck's initial state wants to be added to the equations."""
    source = SOURCES.get(deck.initial.kind)
    return [source(deck)] if source else []


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
    wave = SimpleWave(gas_of(deck), deck.gas.f, deck.initial.temperature, deck.initial.amplitude)
    return along_x(straight(wave.conserved))


@EVOLUTIONS.register("density_wave")
def density_wave(deck: Any) -> Evolution:
    """Density carried along at uniform pressure."""
    gas, n, initial = gas_of(deck), deck.gas.f, deck.initial
    pressure = float(gas.pressure(n, initial.temperature))
    return along_x(straight(DensityWave(gas, n, initial.amplitude, pressure, initial.velocity).conserved))


@EVOLUTIONS.register("eigenmode")
def eigenmode(deck: Any) -> Evolution:
    """A uniform gas at rest and a small mode of the linearized equations."""
    gas, n, T = gas_of(deck), deck.gas.f, deck.initial.temperature
    mode = linear_modes(gas, n, T, deck.gas.tau, 2.0 * np.pi, viscosity_of(deck))[deck.initial.mode]

    def conserved(x: np.ndarray, t: float) -> np.ndarray:
        dn, du, dv, dT = deck.initial.amplitude * n * mode.fields(x, t)
        energy = (n + dn) * (T + dT + 0.5 * du * du + 0.5 * dv * dv)
        return np.stack([n + dn, (n + dn) * du, (n + dn) * dv, energy])

    return along_x(conserved)


@EVOLUTIONS.register("manufactured")
def made_up(deck: Any) -> Evolution:
    """The made-up solution."""
    return manufactured(deck).conserved


def manufactured(deck: Any) -> Manufactured:
    """The made-up solution in the deck's box."""
    strength = getattr(wall_of(deck), "strength", 0.0)
    return Manufactured(gas_of(deck), deck.gas.tau, strength, deck.box.aspect_ratio, viscosity_of(deck))


SOURCES["manufactured"] = lambda deck: Source(manufactured(deck).source)


def straight(conserved: Callable[[np.ndarray, float], np.ndarray]) -> Callable[[np.ndarray, float], np.ndarray]:
    """(n, n u, e)(x, t) with nothing that moves along y."""
    return lambda x, t: np.insert(conserved(x, t), 2, 0.0, axis=0)


def along_x(conserved: Callable[[np.ndarray, float], np.ndarray]) -> Evolution:
    """The evolution of the conserved fields (x, t), averaged over cells."""

    def averages(mesh: Mesh, t: float) -> np.ndarray:
        line = cell_averages(lambda x: conserved(x, t), mesh.x_faces)
        return np.repeat(line[:, :, None], mesh.cells[1], axis=2)

    return averages
