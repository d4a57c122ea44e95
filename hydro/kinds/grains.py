"""`kind = "grains"`: molecular dynamics of a deck, in a folder like that of an evolution.

A cell holds few grains, so what is reported of fields are averages over a window of time, with the standard error that
the scatter within it gives (jackknife over blocks).
"""

from __future__ import annotations

import math
import resource
import time
from collections.abc import Sequence
from typing import Any, cast

import numpy as np

from hydro.check.regime import Place, regime, stripe_of
from hydro.deck import GrainsDeck
from hydro.driver.history import History
from hydro.driver.march import Run
from hydro.grains import books, theory
from hydro.grains.dynamics import Dynamics
from hydro.grains.fields import density_scale, fields, temperature
from hydro.grains.integrator import (
    GrainsIntegrator,
    Sample,
    beginning,
    dynamics_again,
    first_dynamics,
    wall_kind,
)
from hydro.grains.placement import number_of_grains
from hydro.kinds.evolution import Engine, Keeper, go_on, restore, start, state_of
from hydro.mesh import Mesh
from hydro.observables.clustering import arrangement, half_waves, wall_extremes, wall_profile
from hydro.output.checkpoint import Checkpoint, averaged
from hydro.output.folder import RunFolder
from hydro.setup import gas_of, mesh_of
from hydro.state import State

BLOCKS = 8
ENOUGH = 10.0  # grains counted in a cell, over all looks, before it has a temperature
ERRORS = ("wall_max", "wall_min", "gas_density", "thermal_energy")  # whose errors the scatter within a window gives


def solve(deck: GrainsDeck, folder: RunFolder, quiet: bool = False) -> dict[str, Any]:
    """Run the deck in its folder; returns the summary. Errors come through as for an evolution."""
    return start(GRAINS, deck, folder, quiet)


def resume(deck: GrainsDeck, folder: RunFolder, quiet: bool = False) -> dict[str, Any]:
    """Go on with the run in a folder; all is as for an evolution, the bits at the end too."""
    return go_on(GRAINS, deck, folder, quiet)


def begin(deck: GrainsDeck, saved: Checkpoint | None) -> tuple[Run, float]:
    """The grains where the deck puts them or a checkpoint has them, all compiled, and the seconds that took."""
    started = time.perf_counter()
    if saved is None:
        grains, mesh = first_dynamics(deck), mesh_of(deck)
        state = State(gas_of(deck), mesh, fields(grains, mesh))
    else:
        grains, state = dynamics_again(deck, saved.memory), state_of(deck, saved)
    grains.advance(grains.time)
    compile_seconds = time.perf_counter() - started
    run = Run(state, GrainsIntegrator(grains, deck.window), deck.time.end)
    if saved is not None:
        restore(run, saved)
    return run, compile_seconds


def grains_of(run: Run) -> Dynamics:
    """The grains of a run."""
    return cast(GrainsIntegrator, run.integrator).grains


def looks(run: Run) -> Sequence[Sample]:
    """The latest looks at the fields; before the first step, the state itself."""
    samples = cast(GrainsIntegrator, run.integrator).samples
    return samples or [Sample(run.state.time, run.state.conserved, 0.0)]


def mean_fields(samples: Sequence[Sample]) -> np.ndarray:
    """Averages over looks, shape (4, nx, ny)."""
    return np.mean([sample.conserved for sample in samples], axis=0)


def mean_state(run: Run) -> State:
    """The average over the window."""
    return State(run.state.gas, run.state.mesh, mean_fields(looks(run)), run.state.time)


def measures(conserved: np.ndarray, mesh: Mesh) -> dict[str, float]:
    """Wall densities, the mean density in the last cells before x = 1, and the energy of random motion."""
    low, high = wall_extremes(conserved[0], mesh)
    thermal = mesh.integral(conserved[0] * temperature(conserved))
    gas = float(conserved[0, -1] @ mesh.dy) / mesh.aspect_ratio
    return {"wall_max": high, "wall_min": low, "gas_density": gas, "thermal_energy": thermal}


def measured(seen: np.ndarray, mesh: Mesh) -> dict[str, float]:
    """Measures of the average over looks, (looks, 4, nx, ny), with standard errors; NaN where these are too few."""
    found = measures(seen.mean(axis=0), mesh)
    errors = dict.fromkeys(ERRORS, math.nan)
    if len(seen) >= BLOCKS:
        length = len(seen) // BLOCKS
        blocks = np.array([seen[k * length : (k + 1) * length].mean(axis=0) for k in range(BLOCKS)])
        rest = [measures((blocks.sum(axis=0) - block) / (BLOCKS - 1), mesh) for block in blocks]
        errors = {key: math.sqrt(BLOCKS - 1) * float(np.std([row[key] for row in rest])) for key in ERRORS}
    return found | {f"{key}_error": error for key, error in errors.items()}


def mean_pressure(run: Run) -> float:
    """Of the window, by the virial theorem, in n_c T_*: thermal energy per area and momentum carried in collisions."""
    samples = looks(run)
    area, span = run.state.mesh.aspect_ratio, samples[-1].time - samples[0].time
    kinetic = run.state.mesh.integral(mean_fields(samples)[3])
    virial = (samples[-1].virial - samples[0].virial) / density_scale(grains_of(run).arena.diameter)
    return (kinetic + 0.5 * virial / span) / area if span > 0.0 else math.nan


def observed(run: Run) -> dict[str, float]:
    """What summary and history say of a moment: averages over the window before it."""
    samples, state = looks(run), run.state
    mean = mean_fields(samples)
    counts = mean[0] * state.mesh.areas * density_scale(grains_of(run).arena.diameter) * len(samples)
    n = np.where(mean[0] > 0.0, mean[0], math.inf)
    speed = np.hypot(mean[1], mean[2]) / n
    with np.errstate(all="ignore"):
        mach = speed / state.gas.sound_speed(mean[0], temperature(mean))  # not a number from n_c on
    return {
        "time": state.time,
        **measured(np.array([sample.conserved for sample in samples]), state.mesh),
        "half_waves": half_waves(wall_profile(mean[0], state.mesh), state.mesh),
        "mean_pressure": mean_pressure(run),
        "max_speed": float(speed.max()),
        "max_mach": float(np.max(mach, initial=0.0, where=(counts > ENOUGH) & np.isfinite(mach))),
        "contrast": float(mean[0].max() / (mean[0, -1].min() or math.nan)),
    }


class GrainsHistory(History):
    """A history of averages over the window."""

    def _row(self, run: Run) -> dict[str, float]:
        state, seen = run.state, mean_state(run)
        n, momentum_x, momentum_y, _ = seen.conserved
        moving = 0.5 * (momentum_x**2 + momentum_y**2) / np.where(n > 0.0, n, math.inf)
        energy = {"mass": state.mass, "kinetic_energy": state.mesh.integral(moving)}
        return {**observed(run), **arrangement(seen), **energy, **run.ledger.balance(state.energy)}


class GrainsKeeper(Keeper):
    """Keeps snapshots of averages, checkpoints with all grains and the looks at them, and the summary."""

    def snapshot(self, run: Run) -> None:
        """Note the averages, draw their density and the grains, and save a checkpoint to keep."""
        self.note(run, observed(run))
        if self.deck.output.pictures:
            from hydro.pictures.grains import draw  # matplotlib is slow to import

            name = f"grains_{len(self.snapshots):04d}.png"
            draw(self.folder.pictures / name, grains_of(run), self.deck.output.colour)

    def seen(self, run: Run) -> State:
        """The average over the window."""
        return mean_state(run)

    def shown(self, like: State, saved: Checkpoint) -> State:
        """The average over the window before a checkpoint."""
        return State(like.gas, like.mesh, averaged(saved), saved.time)

    def _draw_profiles(self, states: list[State]) -> None:
        """None: cells without grains have no temperature."""

    def _summary(self, run: Run, seconds: float, completed: bool) -> dict[str, Any]:
        grains = grains_of(run)
        collisions = grains.count(books.COLLISIONS)
        return {
            "kind": self.deck.kind,
            "completed": completed,
            "cells": list(run.state.mesh.cells),
            "grains": grains.number,
            "diameter": grains.arena.diameter,
            "restitution": grains.arena.restitution,
            "wall": type(grains.wall).__name__,
            "time": run.state.time,
            "steps": run.steps,
            "collisions": collisions,
            "collisions_per_second": collisions / seconds,
            "wall_hits": grains.count(books.WALL_HITS),
            "soft_collisions": grains.count(books.SOFT),
            "wall_seconds": seconds,
            "peak_memory_bytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
            "mass_drift": run.state.mass / run.ledger.initial_mass - 1.0,
            "smallest_gap": grains.smallest_gap,
            "energy_ledger": run.ledger.balance(run.state.energy),
            "snapshots": self.snapshots,
        }


def describe(deck: GrainsDeck) -> list[str]:
    """Lines on the grains of a deck and what they match, for `check`."""
    mean, T = beginning(deck)
    d, r = deck.diameter, deck.restitution
    number = number_of_grains(mean, d, deck.box.aspect_ratio)
    rate = theory.collision_rate(mean, T, d)
    cooling, conduction = theory.cooling_mu(deck.gas.gamma), theory.conduction_mu(deck.gas.alpha)
    lines = [
        f"{number} grains of diameter d/L_x = {d:.6g}, restitution r = {r:.6g} (1-r^2 = {1.0 - r * r:.4g})",
        f"L = {deck.gas.L:.6g}, f = {mean:.6g}, K = {deck.gas.K:.6g}",
        f"split by mu = {deck.gas.mu:g}; dilute kinetic theory has mu = {conduction:.3g} from conduction and "
        f"{cooling:.3g} from cooling,",
        f"so dilute grains conduct like K = {conduction * d:.3g} and have the densities of "
        f"L = {deck.gas.L * cooling / conduction:.4g}",
        f"about {0.5 * number * rate * deck.time.end:.2g} collisions, were density and temperature those of the start",
        f"driving wall: {wall_kind(deck)}",
        *driven(deck, Place(deck.gas.L, mean, deck.box.aspect_ratio)),
    ]
    if not math.isclose(mean, deck.gas.f, rel_tol=1e-9):
        lines.append(f"warning: gas.f is not used: the initial state has the mean density {mean:.4g}")
    if math.isfinite(deck.gas.tau):
        lines.append("warning: gas.tau is not used: grains know no rolling friction")
    return lines


@np.errstate(all="ignore")  # scales may be beyond all numbers
def driven(deck: GrainsDeck, place: Place) -> list[str]:
    """How fast the wall is, and where the paper's closures have such a gas: beside the marginal curve, and within what
    they assume.
    """
    lines = [f"A omega = {deck.wall_speed:.4g} T_*^(1/2)"] if deck.wall_speed else []
    if deck.moving_wall:
        amplitude, omega = deck.moving_wall
        lines.append(f"A = {amplitude:.4g} L_x, omega = {omega:.4g} T_*^(1/2)/L_x")
    stripe = stripe_of(deck, place)
    if wall_kind(deck) == "sawtooth" and stripe.state is not None:
        share = sawtooth_heat(deck.wall_speed / stripe.wall_temperature**0.5)
        lines.append(f"warning: a sawtooth wall does work p u: about {share:.3g} times the heat that W stands for")
    return [*lines, *regime(deck, [place])]


def sawtooth_heat(speed: float) -> float:
    """Heat of a sawtooth wall over (2/pi)^(1/2) A^2 omega^2 n T^(1/2), for A omega/T^(1/2) = `speed`.

    q = n T u + 2 n u^2 (T/(2 pi))^(1/2), with u = A omega/pi: exact for lone grains that come as a Maxwellian flux.
    """
    u = speed / math.pi
    return (u + 2.0 * u**2 / math.sqrt(2.0 * math.pi)) / (math.sqrt(2.0 / math.pi) * speed**2)


def closing(summary: dict[str, Any]) -> list[str]:
    """The snapshots, and how the run went."""
    rows = [
        f"t={row['time']:<8g} wall max {with_error(row, 'wall_max')}  min {with_error(row, 'wall_min')}  "
        f"gas {with_error(row, 'gas_density')}"
        for row in summary["snapshots"]
    ]
    lines = [
        *rows,
        f"{summary['grains']} grains, {summary['collisions']} collisions in {summary['wall_seconds']:.1f} s: "
        f"{summary['collisions_per_second']:.3g} a second; energy residual {summary['energy_ledger']['residual']:.1e}",
    ]
    if soft := summary["soft_collisions"]:
        share = soft / summary["collisions"]
        lines.append(f"grains.contact_time acted: {soft} of the collisions were elastic, {share:.2%}")
    return lines


def with_error(row: dict[str, Any], key: str) -> str:
    """A number of a snapshot, and its standard error where it is known."""
    error = row[f"{key}_error"]
    known = error is not None and math.isfinite(error)
    return f"{row[key]:.4f} ± {error:.4f}" if known else f"{row[key]:.4f}"


def scalars(summary: dict[str, Any]) -> dict[str, Any]:
    """Numbers that describe the run: those of its last snapshot among them."""
    return {**summary, **(summary["snapshots"] or [{}])[-1]}


GRAINS = Engine(begin, GrainsKeeper, GrainsHistory)
