"""Observables that every state has; the sets of problems extend them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from hydro.accounts import ENERGY
from hydro.mesh import Mesh
from hydro.observables.sets import Curve, Observables, Panel, Quantity, Span
from hydro.state import State


def mean_pressure(state: State, wall: Any) -> float:
    """Mean of the pressure over the box."""
    return state.mesh.integral(state.pressure) / state.mesh.aspect_ratio


def kinetic_energy(state: State, wall: Any) -> float:
    """Energy of the flow, none where there are no grains."""
    n, momentum_x, momentum_y, _ = state.conserved
    return state.mesh.integral(0.5 * (momentum_x**2 + momentum_y**2) / np.where(n > 0.0, n, np.inf))


def thermal_energy(state: State, wall: Any) -> float:
    """Energy of random motion."""
    return state.energy - kinetic_energy(state, wall)


def temperature(conserved: np.ndarray) -> np.ndarray:
    """Of the fields of grains, (nx, ny); zero where there are none."""
    n, momentum_x, momentum_y, energy = conserved
    there = np.where(n > 0.0, n, np.inf)
    return energy / there - 0.5 * (momentum_x**2 + momentum_y**2) / there**2


def thermal_energy_by_cell(state: State, wall: Any) -> float:
    """The same of the fields of grains."""
    return state.mesh.integral(state.density * temperature(state.conserved))


def extremes(density: np.ndarray, mesh: Mesh) -> tuple[float, float]:
    """Smallest and largest density of all cells."""
    return float(density.min()), float(density.max())


TIME = Quantity("time", "time", "L_x/T_*^(1/2)", lambda state, _: state.time, "t")
KINETIC = Quantity("kinetic_energy", "energy of the flow", ENERGY, kinetic_energy)
THERMAL = Quantity("thermal_energy", "energy of random motion", ENERGY, thermal_energy, average=thermal_energy_by_cell)
MEANS = (
    Quantity("mean_pressure", "mean pressure", "n_c T_*", mean_pressure),
    Quantity("max_speed", "largest speed of the flow", "T_*^(1/2)", lambda state, _: float(state.speed.max())),
    Quantity("max_mach", "largest Mach number", "1", lambda state, _: float(state.mach.max())),
)
PANELS = (
    Panel(
        "Energies",
        "energy $/(n_cT_*L_x^2)$",
        (Curve("thermal_energy", "of random motion"), Curve("kinetic_energy", "of the flow", "--")),
    ),
    Panel("The flow's largest Mach number", "largest Mach number", (Curve("max_mach"),)),
)
SPAN = Span("$n$", "in the box", extremes)


def extended(
    name: str,
    fits: Callable[[Any], bool],
    summary: tuple[Quantity, ...],
    history: tuple[Quantity, ...] = (),
    estimated: tuple[Quantity, ...] = (),
    averages: tuple[Quantity, ...] = (),
    closing: tuple[tuple[str, str, str], ...] = (),
    compared: tuple[Quantity, ...] = (),
    drifting: tuple[str, ...] = (),
    panels: tuple[Panel, ...] = (),
    overlaid: tuple[Panel, ...] = (),
    span: Span = SPAN,
    drawn: tuple[str, ...] = (),
) -> Observables:
    """A set with the observables of every state beside its own; arguments as in `Observables`."""
    return Observables(
        name, fits, (TIME, *summary, *MEANS), history, (KINETIC, THERMAL), (*estimated, THERMAL), averages,
        (*closing, ("max_mach", "Mach", ".1e")), compared, drifting, (*panels, *PANELS), overlaid, span,
        drawn,
    )  # fmt: skip
