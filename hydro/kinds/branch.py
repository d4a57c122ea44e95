"""`kind = "branch"`: branches of localized states, from the extended state through bifurcations and folds.

Every finished point is kept as a checkpoint and as a row of points.csv, whatever happens after it.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import islice, pairwise
from typing import Any

import numpy as np

from hydro.check.regime import Place, regime
from hydro.deck import BranchDeck, dumps
from hydro.driver.trackers import StopOnSignal
from hydro.errors import HydroError, RunFailed
from hydro.kinds.kind import Kind
from hydro.observables.clustering import CLUSTERING, profile
from hydro.output.checkpoint import Checkpoint, write_checkpoint
from hydro.output.folder import RunFolder
from hydro.progress import Tally
from hydro.setup import gas_of, mesh_of, wall_of
from hydro.steady.balance import Balance
from hydro.steady.bifurcation import ExtendedBranch
from hydro.steady.continuation import Family, Point, fold_between, follow
from hydro.steady.growth import growth_of
from hydro.steady.localized import SteadyState, chain, unit_cell

EXTENDED = "extended"
SAME = 1e-3  # relative distance in the parameter within which a branch has come back at a known bifurcation


@np.errstate(all="ignore")  # what is not a number ends as a failed search
def solve(deck: BranchDeck, folder: RunFolder, quiet: bool = False) -> dict[str, Any]:
    """Follow the deck's branches and write its folder; returns the summary.

    A HydroError on the way (a branch that is lost, a signal) comes through after what was found has been saved.
    """
    started = time.perf_counter()
    folder.prepare(dumps(deck))
    survey = Survey(deck, folder, Tally(folder.path.name, quiet))
    try:
        with StopOnSignal() as stop:
            survey.run(stop)
    except HydroError as error:
        survey.finish(time.perf_counter() - started, completed=False)
        raise type(error)(f"{error}\n{len(survey.points)} points are saved in {folder.path}") from error
    return survey.finish(time.perf_counter() - started, completed=True)


@dataclass
class Survey:
    """The work on one deck: what it has found so far."""

    deck: BranchDeck
    folder: RunFolder
    tally: Tally
    points: list[dict[str, Any]] = field(default_factory=list)
    folds: list[dict[str, Any]] = field(default_factory=list)
    bifurcations: list[dict[str, Any]] = field(default_factory=list)
    secondary: list[dict[str, Any]] = field(default_factory=list)

    def __post_init__(self) -> None:
        deck, branch = self.deck, self.deck.branch
        # what the branch is followed in may be NaN
        self.whole = Balance.of(gas_of(deck), wall_of(deck), mesh_of(deck), deck.gas.f or math.nan)
        self.family = Family(self.whole.on(unit_cell(self.whole.mesh, branch.wave)), branch.parameter)
        self.extended = ExtendedBranch(self.family)
        self.per_box = branch.wave if branch.parameter == "aspect_ratio" else 1
        low, high = sorted((branch.start, branch.stop))
        self.limits = (low / self.per_box, high / self.per_box)

    def run(self, stop: StopOnSignal) -> None:
        """The extended states, then every branch that leaves them within the limits."""
        values = np.geomspace(*self.limits, self.deck.branch.samples)
        for value in values:
            self.record(self.extended.vector(value), EXTENDED)
            stop.check(f"at {self.where(value)}")
        for bifurcation in self.extended.bifurcations(values):
            if not self.known(bifurcation):
                self.follow(bifurcation, stop)
        if not self.bifurcations:
            raise RunFailed(self.nothing_found())

    def follow(self, start: Point, stop: StopOnSignal) -> None:
        """One branch: its points, folds, and where it ends."""
        name = f"branch {len(self.bifurcations) + 1}"
        self.bifurcations.append(self.bifurcation(start, name))
        first, before = len(self.points), None
        points = follow(self.family, start, self.limits, self.deck.branch.step)
        for point in islice(points, self.deck.branch.points):
            if before is not None and (fold := fold_between(self.family, before, point)) is not None:
                self.folds.append(self.record(fold.vector, name) | {"branch": name})
            row = self.record(point.vector, name)
            if before is None:
                self.bifurcations[-1]["direction"] = self.direction(row)
            before = point
            stop.check(f"at {self.where(point.value)}")
        self.secondary += secondary_bifurcations(self.points[first:], self.deck.branch.parameter, self.own_sector)
        if before is not None:
            self.note_return(before, name)

    def note_return(self, last: Point, name: str) -> None:
        """Enter the bifurcation that the branch came back to, if its last point lies at one inside the limits."""
        inside = self.limits[0] * (1.0 + SAME) < last.value < self.limits[1] * (1.0 - SAME)
        if not inside or self.family.amplitude(last.vector) > 1.0:
            return
        span = last.value * np.array([1.0 - 0.05, 1.0 + 0.05])
        for found in self.extended.bifurcations(np.clip(span, *self.limits)):
            self.bifurcations.append(self.bifurcation(found, name) | {"direction": self.direction(self.points[-1])})

    def bifurcation(self, found: Point, branch: str) -> dict[str, Any]:
        """The entry of a bifurcation whose first state is not known yet."""
        on_wall = profile(self.family.at(found.vector[-1]).state(found.vector[:-1]))
        return self.place(found.value) | {"branch": branch, "direction": "unknown", "wall_max": float(on_wall[0])}

    def direction(self, row: dict[str, Any]) -> str:
        """The kind of bifurcation, from a state next to it: stable states leave a supercritical one."""
        return "supercritical" if row["growth_rates"][self.own_sector] < 0.0 else "subcritical"

    def known(self, start: Point) -> bool:
        """Whether a branch has already been followed from, or to, this bifurcation."""
        parameter = self.deck.branch.parameter
        here = self.place(start.value)[parameter]
        return any(abs(entry[parameter] / here - 1.0) < SAME for entry in self.bifurcations)

    @property
    def own_sector(self) -> str:
        """The symmetry that the branch keeps."""
        return "symmetric" if self.deck.branch.wave % 2 == 0 else "all"

    def record(self, vector: np.ndarray, branch: str) -> dict[str, Any]:
        """Analyse a point, save it, and note it."""
        steady = self.steady(vector, 0 if branch == EXTENDED else self.deck.branch.wave)
        growths = growth_of(steady, self.deck.gas.tau, 1, self.deck.gas.viscosity)
        rates = {growth.sector: growth.rate for growth in growths}
        rate = max(rates.values())
        state = steady.state
        seen = CLUSTERING.snapshot(state, steady.balance.wall)
        row = self.place(math.exp(vector[-1])) | {
            "branch": branch,
            "wall_max": seen["wall_max"],
            "wall_min": seen["wall_min"],
            "gas_density": seen["gas_density"],
            "stable": rate < 0.0,
            "growth_rate": rate,
            "growth_rates": rates,
            "checkpoint": f"{len(self.points) + 1:04d}.h5",
        }
        write_checkpoint(self.folder.checkpoints / row["checkpoint"], Checkpoint.of(state, dumps(self.deck)))
        self.points.append(row)
        self._append(row)
        self.tally.add(self.where(math.exp(vector[-1])))
        return row

    def steady(self, vector: np.ndarray, wave: int) -> SteadyState:
        """The state of the whole box at a vector of the family."""
        cell = self.family.at(vector[-1]).mesh
        whole = self.whole.with_parameter(self.deck.branch.parameter, math.exp(vector[-1]) * self.per_box)
        unknowns = chain(vector[:-1], cell, whole.mesh, shifted=False)
        return SteadyState(whole, wave, unknowns, 0, 0.0)

    def place(self, value: float) -> dict[str, Any]:
        """L, f and aspect ratio where the family's parameter has a value."""
        deck = self.deck
        fixed = {"L": deck.gas.L, "f": deck.gas.f, "aspect_ratio": deck.box.aspect_ratio}
        return fixed | {deck.branch.parameter: value * self.per_box}

    def where(self, value: float) -> str:
        """The parameter in words."""
        return f"{self.deck.branch.parameter} = {value * self.per_box:.6g}"

    def nothing_found(self) -> str:
        """Why there is no branch to follow."""
        branch, rates = self.deck.branch, [self.extended.half_wave(value)[0] for value in self.limits]
        always = "grows" if min(rates) > 0.0 else "decays"
        return (
            f"no bifurcation: between {branch.parameter} = {branch.start:g} and {branch.stop:g} a perturbation of "
            f"{branch.wave} half-wave(s) of the extended state {always}; {branch.samples} states were tried"
        )

    def _append(self, row: dict[str, Any]) -> None:
        columns = ("branch", "L", "f", "aspect_ratio", "wall_max", "wall_min", "gas_density", "stable", "growth_rate")
        with self.folder.points.open("a", encoding="utf-8") as file:
            if file.tell() == 0:
                file.write(",".join(columns) + "\n")
            file.write(",".join(str(row[column]) for column in columns) + "\n")

    def finish(self, seconds: float, completed: bool) -> dict[str, Any]:
        """Write the summary and the picture."""
        summary = {
            "kind": self.deck.kind,
            "completed": completed,
            "cells": list(self.deck.mesh.cells),
            "parameter": self.deck.branch.parameter,
            "wave": self.deck.branch.wave,
            "wall": self.deck.wall.kind,
            "wall_seconds": seconds,
            "damping": self.deck.damping,
            "assumed": self.deck.assumed,
            "points": self.points,
            "folds": self.folds,
            "bifurcations": self.bifurcations,
            "secondary": self.secondary,
            "hysteresis": hysteresis(self.bifurcations, self.folds, self.deck.branch.parameter),
        }
        self.folder.write_summary(summary)
        if self.points:
            from hydro.pictures.branches import bifurcation_diagram  # matplotlib is slow to import

            bifurcation_diagram(self.folder.pictures / "branches", summary)
        return summary


def secondary_bifurcations(points: list[dict[str, Any]], parameter: str, own: str) -> list[dict[str, Any]]:
    """Where a growth rate in another symmetry than the branch's own changes sign, by linear interpolation."""
    found = []
    for before, after in pairwise(points):
        for sector in before["growth_rates"].keys() - {own}:
            low, high = before["growth_rates"][sector], after["growth_rates"].get(sector, math.nan)
            if low * high < 0.0:
                share = low / (low - high)
                value = before[parameter] + share * (after[parameter] - before[parameter])
                wall_max = before["wall_max"] + share * (after["wall_max"] - before["wall_max"])
                found.append({parameter: value, "sector": sector, "wall_max": wall_max})
    return found


def hysteresis(bifurcations: list[dict], folds: list[dict], parameter: str) -> list[dict[str, Any]]:
    """Intervals of the parameter from a subcritical bifurcation to the fold of its branch: both states are there."""
    found = []
    for start in bifurcations:
        turns = [fold[parameter] for fold in folds if fold["branch"] == start["branch"]]
        if start["direction"] == "subcritical" and turns:
            nearest = min(turns, key=lambda value: abs(value - start[parameter]))
            found.append({"branch": start["branch"], "from": start[parameter], "to": nearest})
    return found


def scalars(summary: dict[str, Any]) -> dict[str, Any]:
    """Numbers that describe the branches: the smallest and largest parameters at bifurcations and at folds."""
    parameter = summary["parameter"]
    ends: dict[str, Any] = {}
    for what in ("bifurcation", "fold"):
        values = [entry[parameter] for entry in summary[f"{what}s"]]
        ends |= {f"first_{what}": min(values, default=None), f"last_{what}": max(values, default=None)}
    return {**summary, **ends}


def describe(deck: BranchDeck) -> list[str]:
    """Lines on what will be computed, for `check`."""
    branch = deck.branch
    fixed: dict[str, Any] = {"L": deck.gas.L, "f": deck.gas.f, "aspect_ratio": deck.box.aspect_ratio}
    return [
        f"extended states at {branch.samples} values of {branch.parameter} from {branch.start:g} to {branch.stop:g}",
        f"branches with {branch.wave} half-wave(s) in y, up to {branch.points} points on each",
        deck.damping,
        *regime(deck, [Place(**fixed | {branch.parameter: value}) for value in (branch.start, branch.stop)]),
    ]


def closing(summary: dict[str, Any]) -> list[str]:
    """Bifurcations, folds and how many points."""
    parameter = summary["parameter"]
    return [
        *_places(summary, parameter),
        summary["damping"],
        f"{len(summary['points'])} points in {summary['wall_seconds']:.1f} s",
    ]


def _places(summary: dict[str, Any], parameter: str) -> Iterator[str]:
    for entry in summary["bifurcations"]:
        yield f"{entry['branch']}: {entry['direction']} bifurcation at {parameter} = {entry[parameter]:.6g}"
    for entry in summary["folds"]:
        yield f"{entry['branch']}: fold at {parameter} = {entry[parameter]:.6g}, n(0,y) up to {entry['wall_max']:.4f}"
    for entry in summary["secondary"]:
        yield f"{entry['sector']} perturbations change their fate at {parameter} = {entry[parameter]:.6g}"
    for entry in summary["hysteresis"]:
        yield f"{entry['branch']}: hysteresis between {parameter} = {entry['from']:.6g} and {entry['to']:.6g}"


KIND = Kind(solve, describe, closing, scalars)
