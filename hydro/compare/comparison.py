"""A run beside a steady state of its box: how far it is from it, and how fast it comes closer or leaves."""

from __future__ import annotations

from dataclasses import asdict
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from hydro.compare.exponential import NoStretch, exponential_stretch
from hydro.compare.subject import Subject, steady_state_for
from hydro.mesh import Mesh
from hydro.observables import observables_in, observables_of
from hydro.observables.sets import values
from hydro.output.folder import write_json
from hydro.setup import viscosity_of
from hydro.state import State
from hydro.steady.growth import Growth, growth_of, sector_parts
from hydro.steady.localized import SteadyState
from hydro.steady.nearest import aligned, distance, images

ROUND_OFF = 1e-10  # of the steady density: a part of the difference that is never larger is not there
TRANSLATION = 0.99  # correlation with the state's slope in y of the mode that moves it along a periodic box
TOTAL = "total"
FIELDS = ("density", "temperature")

Row = dict[str, Any]


@np.errstate(all="ignore")  # what is not a number ends as a failed search
def compare(path: Path, steady: str, quiet: bool = False) -> dict[str, Any]:
    """Compare the run in the folder `path` with the steady state of the folder `steady`, or the nearest ("auto").

    Writes compare/ in the run's folder: compare.json, which is also returned, and pictures. DeckError for folders that
    cannot be compared, CheckpointError for a damaged file, RunFailed if no steady state is found.
    """
    subject = Subject.of(path)
    found, tried = steady_state_for(subject, steady, quiet)
    alignment, found = closest_image(subject, found)
    growths = growth_of(found, subject.deck.gas.tau, viscosity=viscosity_of(subject.deck))
    rows, parts = table(subject, found, len(growths))
    result = {
        "steady": steady,
        "observables": observables_of(subject.deck).name,
        "wave": found.wave,
        "alignment": alignment,
        "tried": [asdict(attempt) for attempt in tried],
        "cells": list(found.balance.mesh.cells),
        "residual": found.residual,
        "steady_state": numbers(subject, found.state),
        "friction_rate": -1.0 / subject.deck.gas.tau,
        "rates": rates(rows, parts, [(growth.sector, leading(growth, found)) for growth in growths]),
        "checkpoints": rows,
    }
    folder = path / "compare"
    folder.mkdir(exist_ok=True)
    write_json(folder / "compare.json", result)
    draw(folder, subject, found, result, parts)
    return result


def closest_image(subject: Subject, steady: SteadyState) -> tuple[str, SteadyState]:
    """The image of the steady state that the run comes closest to at any time, and its name."""
    shown = list(images(steady))
    distances = [[distance(state, image) for image in shown] for state in subject.states]
    which = int(np.argmin(np.min(distances, axis=0)))
    moved = "shifted by half a wave" if steady.mirrored else "mirrored in y"
    return ("as it is", moved)[which], shown[which]


def table(subject: Subject, steady: SteadyState, sectors: int) -> tuple[list[Row], np.ndarray]:
    """A row for each checkpoint, and the distances in density by symmetry, (sectors, checkpoints)."""
    there, rows, parts = steady.state, [], []
    for state in subject.states:
        here, shift = aligned(state, steady)
        by_field = {field: norms(getattr(here, field), getattr(there, field), here.mesh) for field in FIELDS}
        rows.append(numbers(subject, here) | {"moved": shift} | by_field)
        split = islice(sector_parts(steady, here.density - there.density), sectors)
        parts.append([norms(there.density + part, there.density, here.mesh)["L2"] for part in split])
    return rows, np.array(parts).T


def norms(field: np.ndarray, steady: np.ndarray, mesh: Mesh) -> dict[str, float]:
    """L1, L2 and largest difference of two fields (nx, ny), each over the same norm of the steady one."""
    difference, scale = np.abs(field - steady), np.abs(steady)
    return {
        "L1": mesh.integral(difference) / mesh.integral(scale),
        "L2": float(np.sqrt(mesh.integral(difference**2) / mesh.integral(scale**2))),
        "max": float(difference.max() / scale.max()),
    }


def numbers(subject: Subject, state: State) -> Row:
    """What the table says of a state."""
    return {"time": state.time, **values(observables_of(subject.deck).compared, state, subject.wall)}


def rates(rows: list[Row], parts: np.ndarray, leading_rates: list[tuple[str, float]]) -> list[Row]:
    """Fitted rates beside eigenvalues: of the total distance, and of its part in every symmetry sector.

    The eigenvalue beside the total is the leading one of the sectors that are there at all.
    """
    times, total = np.array([row["time"] for row in rows]), np.array([row["density"]["L2"] for row in rows])
    there = [rate for (_, rate), part in zip(leading_rates, parts, strict=True) if part.max() > ROUND_OFF]
    entries = [(TOTAL, max(there, default=None), total)]
    if len(parts) > 1:
        entries += [(sector, rate, part) for (sector, rate), part in zip(leading_rates, parts, strict=True)]
    return [{"sector": name, "growth_rate": rate, **fitted(times, values)} for name, rate, values in entries]


def fitted(times: np.ndarray, distances: np.ndarray) -> Row:
    """The exponential stretch of a distance, or why there is none."""
    if distances.max() <= ROUND_OFF:
        return {"fit": None, "note": f"round-off: never above {ROUND_OFF:g}"}
    try:
        return {"fit": exponential_stretch(times, distances)._asdict(), "note": ""}
    except NoStretch as reason:
        return {"fit": None, "note": str(reason)}


def leading(growth: Growth, steady: SteadyState) -> float:
    """The largest growth rate of a sector, without the mode that moves a chain along a periodic box."""
    return max(
        (mode.growth_rate.real for mode in growth.modes if not moves(mode.density.real, steady)), default=-np.inf
    )


def moves(density: np.ndarray, steady: SteadyState) -> bool:
    """Whether a perturbation of the density is a motion of the state along a periodic box."""
    if not steady.balance.mesh.periodic[1] or steady.wave == 0:
        return False
    slope = np.roll(steady.state.density, -1, axis=1) - np.roll(steady.state.density, 1, axis=1)
    return abs(np.vdot(slope, density)) > TRANSLATION * np.linalg.norm(slope) * np.linalg.norm(density)


def closing(result: Row) -> list[str]:
    """The last checkpoint beside the steady state, and the rates, as tables."""
    last, steady = result["checkpoints"][-1], result["steady_state"]
    compared = observables_in(result).compared
    where = result["alignment"] + (f", {-last['moved']:.4g} further in y" if last["moved"] else "")
    return [
        *map(attempt_line, result["tried"]),
        f"steady state with {result['wave']} half-waves, {where}; residual {result['residual']:.1e}",
        "",
        f"{'':<24}{'t = ' + format(last['time'], 'g'):>14}{'steady':>14}{'difference':>14}",
        *(number_line(each.label, last[each.name], steady[each.name]) for each in compared),
        "",
        f"{'relative difference':<24}{'L1':>14}{'L2':>14}{'max':>14}",
        *(f"{field:<24}" + "".join(f"{last[field][norm]:14.3e}" for norm in ("L1", "L2", "max")) for field in FIELDS),
        "",
        f"{'distance in density':<24}{'fitted rate':>24}{'eigenvalue':>14}   exponential stretch",
        *map(rate_line, result["rates"]),
        f"{'friction, -1/tau':<24}{'':>24}{result['friction_rate']:14.4e}   of shear flow, which the density follows",
    ]


def number_line(label: str, mine: float, steady: float) -> str:
    """One number of the run and of the steady state."""
    return f"{label:<24}{mine:14.6g}{steady:14.6g}{mine - steady:14.3e}"


def attempt_line(attempt: Row) -> str:
    """One of the states that were tried."""
    outcome = attempt["reason"] or f"distance {attempt['distance']:.3e}"
    return f"tried {attempt['wave']} half-waves: {outcome}"


def rate_line(entry: Row) -> str:
    """Fitted rate and eigenvalue of one sector."""
    fit, rate = entry["fit"], entry["growth_rate"]
    eigenvalue = "-" if rate is None else f"{rate:.4e}"
    if fit is None:
        return f"{entry['sector']:<24}{'-':>24}{eigenvalue:>14}   {entry['note']}"
    shown = f"{fit['rate']:.4e} +- {fit['error']:.0e}"
    window = f"t = {fit['start']:g} to {fit['end']:g}, {fit['points']} checkpoints"
    return f"{entry['sector']:<24}{shown:>24}{eigenvalue:>14}   {window}"


def draw(folder: Path, subject: Subject, steady: SteadyState, result: Row, parts: np.ndarray) -> None:
    """The distance against time, and the last state beside the steady one."""
    from hydro.pictures.comparison import difference_maps, distance_curves  # matplotlib is slow to import

    distance_curves(folder / "distance.png", result, parts)
    difference_maps(folder / "states.png", aligned(subject.last, steady)[0], steady.state)
