"""`kind = "stability"`: critical aspect ratios of extended states, and the tongues in which they exist."""

from __future__ import annotations

import time
from itertools import product
from typing import Any

import numpy as np

from hydro.check.regime import Grains, Place, Stripe, extended_or_none, position, verdicts
from hydro.deck import StabilityDeck, dumps
from hydro.driver.trackers import StopOnSignal
from hydro.errors import HydroError
from hydro.gas import Closure, Grossman
from hydro.kinds.kind import Kind
from hydro.output.folder import RunFolder
from hydro.progress import counted
from hydro.setup import gas_of
from hydro.steady.extended import extended_state
from hydro.steady.marginal import critical_aspect_ratio, tongue

SECONDS_PER_STATE = 0.02  # a guess, good to a factor of two or three on one core of a current processor
SECONDS_PER_TONGUE = 1.0
K = 1.0  # makes no difference to densities


@np.errstate(all="ignore")  # what is not a number ends as a failed search
def solve(deck: StabilityDeck, folder: RunFolder, quiet: bool = False) -> dict[str, Any]:
    """All rows and tongues of the deck, with its picture, in its folder; returns the summary.

    A HydroError on the way (no state found, a signal) comes through after what is finished has been saved.
    """
    started = time.perf_counter()
    folder.prepare(dumps(deck))
    summary: dict[str, Any] = {"kind": deck.kind, "completed": False, "rows": [], "tongues": []}
    try:
        with StopOnSignal() as stop:
            _fill(summary, deck, stop, folder.path.name, quiet)
        summary["completed"] = True
    except HydroError as error:
        message = f"{error}\n{len(summary['rows'])} rows are finished and saved in {folder.summary}"
        raise type(error)(message) from error
    finally:
        summary["wall_seconds"] = time.perf_counter() - started
        folder.write_summary(summary)
        if summary["rows"]:
            _draw(summary, deck, folder)
    return summary


def _fill(summary: dict[str, Any], deck: StabilityDeck, stop: StopOnSignal, title: str, quiet: bool) -> None:
    """Enter rows, then tongues, into the summary."""
    wanted = deck.stability
    places = list(product(wanted.L, wanted.area_fractions))
    for L, f in counted(places, title, quiet):
        stop.check(f"before L = {L:g}, f = {f:g}")
        summary["rows"] += [{"L": L, **row} for row in rows(gas_of(deck, L=L, K=K), f, wanted.walls, wanted.waves)]
    for L, wall in counted(list(product(wanted.L, wanted.walls)), f"{title}, tongues", quiet):
        stop.check(f"before the tongue at L = {L:g}, {wall} wall")
        found = tongue(gas_of(deck, L=L, K=K), wall)
        summary["tongues"].append({"L": L, "wall": wall, **vars(found)})


def rows(gas: Closure, f: float, walls: tuple[str, ...], waves: tuple[int, ...]) -> list[dict[str, Any]]:
    """The critical aspect ratios of one extended state."""
    state = extended_state(gas, f)
    found: list[dict[str, Any]] = []
    for wall in walls:
        first = critical_aspect_ratio(state, wall)
        for m in waves:
            place = {"f": f, "wall": wall, "m": m}
            found.append({**place, "aspect_ratio": first.times(m).aspect_ratio, "error": first.times(m).error})
    return found


def describe(deck: StabilityDeck) -> list[str]:
    """What the deck asks for, and what to expect."""
    wanted = deck.stability
    states, tongues = len(wanted.L) * len(wanted.area_fractions), len(wanted.L) * len(wanted.walls)
    ratios = len(wanted.walls) * len(wanted.waves)
    lines = [
        f"{states} extended states, {ratios} critical aspect ratio{'' if ratios == 1 else 's'} for each, "
        f"and {tongues} tongues: about {states * SECONDS_PER_STATE + tongues * SECONDS_PER_TONGUE:.0f} s",
    ]
    return [*lines, *limits_of([gas_of(deck, L=L, K=K) for L in wanted.L]), *marked(deck)]


def limits_of(gases: list[Closure]) -> list[str]:
    """What formulas say of the paper's closures, for each L."""
    from hydro.steady.grossman_limits import dense_rate, dilute_end, least_aspect_ratio

    papers = [gas for gas in gases if isinstance(gas, Grossman)]
    lines = ["for each L: depth 1/k over which a dense cluster changes, f_1 of Eq. (asymp), least Delta_1 of large L"]
    for gas in papers:
        ratio = least_aspect_ratio(gas)
        least = "not known for this alpha" if ratio is None else f"about {ratio:.3g}"
        rate, end = dense_rate(gas), dilute_end(gas)
        lines.append(f"L = {gas.L:<10g} 1/k {1.0 / rate:<10.3g} f_1 {end:<10.3g} Delta_min {least}")
    return lines if papers else []


def marked(deck: StabilityDeck) -> list[str]:
    """Where the points lie that are to be marked, and how well the equations hold for the experiment, if it is one."""
    wanted, scaled = deck.stability, deck.scaled
    places = [Place(L, point.f, point.aspect_ratio) for L in wanted.L for point in wanted.points]
    states = [extended_or_none(gas_of(deck, L=place.L, K=K), place.f) for place in places]
    lines = [position(states[k], places[k], wall) for k in range(len(places)) for wall in wanted.walls]
    if scaled is not None:
        lines += verdicts([Stripe(places[0], Grains.of_experiment(scaled), states[0])])
    return lines


def scalars(summary: dict[str, Any]) -> dict[str, Any]:
    """Numbers that describe the first row and the first tongue."""
    return {**summary, **summary["rows"][0], **summary["tongues"][0]}


def closing(summary: dict[str, Any]) -> list[str]:
    """The tongues, and how many critical aspect ratios there are."""
    found = [row for row in summary["rows"] if row["aspect_ratio"] is not None]
    worst = max((row["error"] / row["aspect_ratio"] for row in found), default=0.0)
    lines = []
    for entry in summary["tongues"]:
        place = f"L={entry['L']:<8g} {entry['wall']:<10}"
        if entry["f1"] is None:
            lines.append(f"{place} no tongue: stable for every aspect ratio")
        else:
            lines.append(
                f"{place} tongue {entry['f1']:.4g} < f < {entry['f2']:.4g}, "
                f"least aspect ratio {entry['aspect_ratio_min']:.5g} at f={entry['f_min']:.5g}"
            )
    count = f"{len(found)} of {len(summary['rows'])} points have a critical aspect ratio"
    return [*lines, f"{count}, relative error {worst:.0e} or less; {summary['wall_seconds']:.1f} s"]


def _draw(summary: dict[str, Any], deck: StabilityDeck, folder: RunFolder) -> None:
    from hydro.pictures.marginal import draw  # matplotlib is slow to import

    points = [(point.f, point.aspect_ratio, point.label) for point in deck.stability.points]
    draw(folder.pictures / "marginal", summary["rows"], summary["tongues"], points)


KIND = Kind(solve, describe, closing, scalars)
