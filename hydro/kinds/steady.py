"""`kind = "steady"`: a steady state, its growth rates, and checkpoints to start an evolution from."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from hydro.check.regime import Place, regime
from hydro.deck import SteadyDeck, dumps
from hydro.errors import Complaint, DeckError
from hydro.kinds.kind import Kind
from hydro.observables import CLUSTERING
from hydro.output.checkpoint import Checkpoint, write_checkpoint
from hydro.output.folder import RunFolder
from hydro.setup import gas_of, mesh_of, wall_of
from hydro.state import State, inadmissible, worst_cell
from hydro.steady.growth import Growth, growth_of, growth_rate, with_mode
from hydro.steady.localized import SteadyState, steady_state


@np.errstate(all="ignore")  # what is not a number ends as a failed search
def solve(deck: SteadyDeck, folder: RunFolder, quiet: bool = False) -> dict[str, Any]:
    """Solve for the deck's state and write its folder; returns the summary.

    Nothing in the folder is touched before the state is there. RunFailed if it is not found, or its growth rates;
    DeckError if no state of a gas comes of steady.mode_amplitude.
    """
    wall = wall_of(deck)
    compile_seconds = warm_up(deck, wall)
    started = time.perf_counter()
    steady = steady_state(
        gas_of(deck), wall, mesh_of(deck), deck.gas.f, deck.steady.wave, deck.steady.shifted, deck.steady.search
    )
    solved = time.perf_counter()
    growths = growth_of(steady, deck.gas.tau, deck.steady.modes, deck.gas.viscosity)
    analysed = time.perf_counter()
    states = states_to_keep(deck, steady.state, growths)
    folder.prepare(dumps(deck))
    for name, state in states.items():
        write_checkpoint(folder.checkpoints / f"{name}.h5", Checkpoint.of(state, dumps(deck)))
    summary = {
        **summary_of(deck, steady, growths),
        "wall_seconds": solved - started,
        "stability_seconds": analysed - solved,
        "compile_seconds": compile_seconds,
    }
    folder.write_summary(summary)
    draw(deck, folder, steady, growths, summary)
    return summary


def warm_up(deck: SteadyDeck, wall: Any) -> float:
    """Compile, or load, the kernels; returns the seconds that took."""
    from hydro.walls.boundary import wall_heat

    started = time.perf_counter()
    wall_heat(gas_of(deck), wall, np.full(1, deck.gas.f), np.ones(1), 0.5)
    return time.perf_counter() - started


def summary_of(deck: SteadyDeck, steady: SteadyState, growths: list[Growth]) -> dict[str, Any]:
    """The state in numbers."""
    state = steady.state
    seen = CLUSTERING.snapshot(state, steady.balance.wall)
    rate = growth_rate(growths)
    return {
        "kind": deck.kind,
        "completed": True,
        "cells": list(state.mesh.cells),
        "area_fraction": deck.gas.f,
        "aspect_ratio": deck.box.aspect_ratio,
        "L": deck.gas.L,
        "wall": deck.wall.kind,
        "wave": steady.wave,
        "wall_max": seen["wall_max"],
        "wall_min": seen["wall_min"],
        "gas_density": seen["gas_density"],
        "pressure": seen["mean_pressure"],
        "residual": steady.residual,
        "newton_iterations": steady.iterations,
        "damping": deck.damping,
        "assumed": deck.assumed,
        "stable": rate < 0.0,
        "growth_rate": rate,
        "sectors": [
            {
                "sector": growth.sector,
                "growth_rates": [mode.growth_rate.real for mode in growth.modes],
                "frequencies": [mode.growth_rate.imag for mode in growth.modes],
            }
            for growth in growths
        ],
    }


def states_to_keep(deck: SteadyDeck, state: State, growths: list[Growth]) -> dict[str, State]:
    """The state, and the state plus the leading mode of each sector, by the names of their checkpoints.

    DeckError if one of them is no state of a gas, because the amplitude of the mode is too large for it.
    """
    states = {"steady": state}
    for growth in growths:
        if growth.modes:
            perturbed = with_mode(state, growth.modes[0], deck.steady.mode_amplitude)
            if inadmissible(perturbed).any():
                problem = f"{deck.steady.mode_amplitude:g} is too large, {growth.sector}: {worst_cell(perturbed)}"
                raise DeckError([Complaint("steady.mode_amplitude", problem)])
            states[f"steady_plus_{growth.sector.replace(' ', '_')}"] = perturbed
    return states


def draw(
    deck: SteadyDeck, folder: RunFolder, steady: SteadyState, growths: list[Growth], summary: dict[str, Any]
) -> None:
    """The density in the paper's layout, and the leading modes."""
    from hydro.pictures.density import Map, density_panels  # matplotlib is slow to import
    from hydro.pictures.modes import mode_panels

    state = steady.state
    title = rf"$f={deck.gas.f:g}$, $\Delta={deck.box.aspect_ratio:g}$"
    shown = Map(state.density, state.mesh, title, CLUSTERING.span.note(state.density, state.mesh))
    density_panels(folder.pictures / "density", [shown])
    mode_panels(folder.pictures / "modes", state, [growth.modes[0] for growth in growths if growth.modes])


def describe(deck: SteadyDeck) -> list[str]:
    """Lines on what will be solved, for `check`."""
    nx, ny = deck.mesh.cells
    wave = deck.steady.wave
    unknowns, waves = (nx * ny // wave, f"{wave} half-wave{'' if wave == 1 else 's'}") if wave else (nx, "no waves")
    return [
        f"a steady state with {waves} in y: {unknowns} unknown densities and the pressure",
        deck.damping,
        *regime(deck, [Place(deck.gas.L, deck.gas.f, deck.box.aspect_ratio)]),
    ]


def closing(summary: dict[str, Any]) -> list[str]:
    """The state and its stability in words."""
    lines = [
        f"n on the wall x=0 from {summary['wall_min']:.5f} to {summary['wall_max']:.5f}, "
        f"in the gas at x=1 {summary['gas_density']:.5f}",
        f"{summary['newton_iterations']} Newton iterations in {summary['wall_seconds']:.2f} s, "
        f"residual {summary['residual']:.1e}; growth rates in {summary['stability_seconds']:.2f} s",
        summary["damping"],
    ]
    for sector in summary["sectors"]:
        rates = ", ".join(map(rate_words, sector["growth_rates"], sector["frequencies"]))
        lines.append(f"growth rates, {sector['sector']}: {rates}")
    return [*lines, "stable" if summary["stable"] else "unstable"]


def rate_words(rate: float, frequency: float) -> str:
    """A growth rate, with its frequency where it oscillates."""
    return f"{rate:.4g}+-{frequency:.4g}i" if frequency else f"{rate:.4g}"


KIND = Kind(solve, describe, closing)
