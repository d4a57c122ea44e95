"""`kind = "grains"`: molecular dynamics of a deck, in a folder like that of an evolution.

A cell holds few grains, so what is reported of fields are averages over a window of time, with the standard error that
the scatter within it gives (jackknife over blocks).
"""

from __future__ import annotations

import math
import resource
import time
from collections.abc import Callable, Sequence
from typing import Any, cast

import numpy as np

from hydro.check.regime import Place, regime, stripe_of
from hydro.deck import GrainsDeck
from hydro.driver.history import History
from hydro.driver.keeper import Keeper
from hydro.driver.march import Run
from hydro.driver.run_in_folder import Engine, go_on, restore, start, state_of
from hydro.grains import books, theory
from hydro.grains.dynamics import Dynamics
from hydro.grains.fields import density_scale, fields
from hydro.grains.integrator import (
    GrainsIntegrator,
    Sample,
    beginning,
    dynamics_again,
    first_dynamics,
    wall_kind,
)
from hydro.grains.placement import number_of_grains
from hydro.kinds.kind import Kind
from hydro.observables import Observables, observables_in
from hydro.observables.general import temperature
from hydro.observables.sets import Quantity, Row, error_of
from hydro.output.checkpoint import Checkpoint, averaged
from hydro.output.folder import RunFolder
from hydro.setup import gas_of, mesh_of
from hydro.state import State

BLOCKS = 8
DILUTE = 1e-9  # n of a gas of which mean free paths are all
ENOUGH = 10.0  # grains counted in a cell, over all looks, before it has a temperature


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


def collisions_per_grain(run: Run) -> float:
    """How many a grain has had so far, on average: two grains have each."""
    grains = grains_of(run)
    return 2.0 * grains.count(books.COLLISIONS) / grains.number


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


def measured(quantities: Sequence[Quantity], seen: np.ndarray, like: State) -> Row:
    """Quantities of the average over looks, (looks, 4, nx, ny), with standard errors; NaN where these are too few.

    Gas and mesh are those of `like`.
    """

    def of(conserved: np.ndarray) -> Row:
        state = State(like.gas, like.mesh, conserved)
        return {each.name: each.averaged(state, None) for each in quantities}

    errors = {each.name: math.nan for each in quantities}
    if len(seen) >= BLOCKS:
        length = len(seen) // BLOCKS
        blocks = np.array([seen[k * length : (k + 1) * length].mean(axis=0) for k in range(BLOCKS)])
        rest = [of((blocks.sum(axis=0) - block) / (BLOCKS - 1)) for block in blocks]
        errors = {key: math.sqrt(BLOCKS - 1) * float(np.std([row[key] for row in rest])) for key in errors}
    return of(seen.mean(axis=0)) | {error_of(name): error for name, error in errors.items()}


def mean_pressure(run: Run) -> float:
    """Of the window, by the virial theorem, in n_c T_*: thermal energy per area and momentum carried in collisions."""
    samples = looks(run)
    area, span = run.state.mesh.aspect_ratio, samples[-1].time - samples[0].time
    kinetic = run.state.mesh.integral(mean_fields(samples)[3])
    virial = (samples[-1].virial - samples[0].virial) / density_scale(grains_of(run).arena.diameter)
    return (kinetic + 0.5 * virial / span) / area if span > 0.0 else math.nan


def mean_speeds(run: Run) -> np.ndarray:
    """Speed of the mean flow, (nx, ny); zero where there were no grains."""
    mean = mean_fields(looks(run))
    return np.hypot(mean[1], mean[2]) / np.where(mean[0] > 0.0, mean[0], math.inf)


def max_mach(run: Run) -> float:
    """Largest Mach number of the mean flow, where there were enough grains to have a temperature."""
    samples, state = looks(run), run.state
    mean = mean_fields(samples)
    counts = mean[0] * state.mesh.areas * density_scale(grains_of(run).arena.diameter) * len(samples)
    with np.errstate(all="ignore"):
        mach = mean_speeds(run) / state.gas.sound_speed(mean[0], temperature(mean))  # not a number from n_c on
    return float(np.max(mach, initial=0.0, where=(counts > ENOUGH) & np.isfinite(mach)))


# What grains know better than their mean fields do.
OWN: dict[str, Callable[[Run], float]] = {
    "mean_pressure": mean_pressure,
    "max_speed": lambda run: float(mean_speeds(run).max()),
    "max_mach": max_mach,
}


def observed(run: Run, observables: Observables) -> Row:
    """What summary and history say of a moment: averages over the window before it."""
    mean, seen = mean_state(run), np.array([sample.conserved for sample in looks(run)])
    row = {"time": run.state.time, **measured(observables.estimated, seen, mean)}
    for each in (*observables.summary, *observables.averages):
        if each.name not in row:
            row[each.name] = OWN[each.name](run) if each.name in OWN else each.averaged(mean, None)
    return row


class GrainsHistory(History):
    """A history of averages over the window."""

    def _row(self, run: Run) -> Row:
        seen, mean, row = self.observables, mean_state(run), observed(run, self.observables)
        energies = [each for each in seen.energies if each.name not in row]
        further = {each.name: each.averaged(mean, None) for each in seen.history}
        books = {"mass": run.state.mass, **{each.name: each.averaged(mean, None) for each in energies}}
        further |= {"collisions_per_grain": collisions_per_grain(run)}
        return {**row, **further, **books, **run.ledger.balance(run.state.energy)}


class GrainsKeeper(Keeper):
    """Keeps snapshots of averages, checkpoints with all grains and the looks at them, and the summary."""

    def snapshot(self, run: Run) -> None:
        """Note the averages, draw their density and the grains, and save a checkpoint to keep."""
        self.note(run, observed(run, self.observables))
        if self.deck.output.pictures:
            from hydro.pictures.grains import draw  # matplotlib is slow to import

            name = f"grains_{len(self.snapshots):04d}.png"
            draw(self.folder.pictures / name, grains_of(run), self.deck.output.colour)

    def inspect(self, run: Run) -> None:
        """Nothing: cells without grains have no density."""

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
            "collisions_per_grain": collisions_per_grain(run),
            "collisions_per_second": collisions / seconds,
            "wall_hits": grains.count(books.WALL_HITS),
            "soft_collisions": grains.count(books.SOFT),
            "wall_seconds": seconds,
            "peak_memory_bytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
            "mass_drift": run.state.mass / run.ledger.initial_mass - 1.0,
            "smallest_gap": grains.smallest_gap,
            "energy_ledger": run.ledger.balance(run.state.energy),
            "observables": self.observables.name,
            "snapshots": self.snapshots,
        }


def describe(deck: GrainsDeck) -> list[str]:
    """Lines on the grains of a deck and what they match, for `check`."""
    mean, T = beginning(deck)
    d, r = deck.diameter, deck.restitution
    number = number_of_grains(mean, d, deck.box.aspect_ratio)
    rate = theory.collision_rate(mean, T, d)
    dilute = float(gas_of(deck, K=1.0).conductivity_coefficient(DILUTE))
    cooling, conduction = theory.cooling_mu(deck.gas.gamma), theory.conduction_mu(dilute)
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
    lines = [
        *map(observables_in(summary).closing_line, summary["snapshots"]),
        f"{summary['grains']} grains, {summary['collisions']} collisions in {summary['wall_seconds']:.1f} s: "
        f"{summary['collisions_per_second']:.3g} a second; energy residual {summary['energy_ledger']['residual']:.1e}",
    ]
    if soft := summary["soft_collisions"]:
        share = soft / summary["collisions"]
        lines.append(f"grains.contact_time acted: {soft} of the collisions were elastic, {share:.2%}")
    return lines


def scalars(summary: dict[str, Any]) -> dict[str, Any]:
    """Numbers that describe the run: those of its last snapshot among them."""
    return {**summary, **(summary["snapshots"] or [{}])[-1]}


GRAINS = Engine(begin, GrainsKeeper, GrainsHistory)


KIND = Kind(solve, describe, closing, scalars, resume)
