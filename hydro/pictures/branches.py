"""Bifurcation diagrams: stable states solid, unstable ones dashed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby, pairwise
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from hydro.pictures.style import publish

LABELS = {"f": "area fraction $f$", "aspect_ratio": r"aspect ratio $\Delta$", "L": r"$\mathcal{L}$"}
EXTREMES = (("wall_max", "black"), ("wall_min", "0.55"))
SECTOR_COLOURS = ("black", "tab:red", "tab:blue", "tab:green")

Row = dict[str, Any]


def bifurcation_diagram(path: Path, summary: dict[str, Any]) -> None:
    """Densities on the wall x = 0 and growth rates against the parameter, into `path`.png and `path`.pdf."""
    parameter = summary["parameter"]
    figure = Figure(figsize=(6.0, 6.6), layout="constrained")
    densities, rates = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    branches = branches_of(summary)
    for rows in branches:
        draw_densities(densities, rows, parameter)
    mark(densities, summary, parameter)
    draw_rates(rates, [row for row in branches if row[0]["branch"] != "extended"], parameter)
    densities.set_ylabel("$n/n_c$ on the wall $x=0$")
    rates.set_ylabel("growth rate $\\lambda L_x/T_*^{1/2}$")
    rates.set_xlabel(LABELS[parameter])
    densities.legend(handles=list(legend()), fontsize=8, loc="best")
    publish(figure, path)


def branches_of(summary: dict[str, Any]) -> list[list[Row]]:
    """The points of every branch, in order."""
    return [list(rows) for _, rows in groupby(summary["points"], key=lambda row: row["branch"])]


def draw_densities(axis: Axes, rows: Sequence[Row], parameter: str) -> None:
    """Largest and smallest density along the wall, of one branch; the extended state has but one."""
    extended = rows[0]["branch"] == "extended"
    for column, colour in EXTREMES[:1] if extended else EXTREMES:
        for stable, run in stretches(rows):
            values, densities = [row[parameter] for row in run], [row[column] for row in run]
            axis.plot(values, densities, "-" if stable else "--", color="tab:blue" if extended else colour, lw=1.2)


def stretches(rows: Sequence[Row]) -> Iterator[tuple[bool, list[Row]]]:
    """Runs of points of equal stability; they meet where the growth rate between their points is zero."""
    runs = [(stable, list(run)) for stable, run in groupby(rows, key=lambda row: row["stable"])]
    for (_, before), (_, after) in pairwise(runs):
        meeting = marginal(before[-1], after[0])
        before.append(meeting)
        after.insert(0, meeting)
    yield from runs


def marginal(before: Row, after: Row) -> Row:
    """The place between two points of a branch where the growth rate is zero, by linear interpolation."""
    share = before["growth_rate"] / (before["growth_rate"] - after["growth_rate"])
    numbers = ("L", "f", "aspect_ratio", "wall_max", "wall_min")
    return {key: before[key] + share * (after[key] - before[key]) for key in numbers}


def mark(axis: Axes, summary: dict[str, Any], parameter: str) -> None:
    """Folds as circles, bifurcations as squares, with thin lines from there to the first, or last, of the branch."""
    for fold in summary["folds"]:
        axis.plot(fold[parameter], fold["wall_max"], "o", color="black", mfc="white", ms=5, zorder=3)
    for start in summary["bifurcations"]:
        axis.plot(start[parameter], start["wall_max"], "s", color="tab:blue", mfc="white", ms=5, zorder=3)
        for row in ends_at(start, summary, parameter):
            for column, colour in EXTREMES:
                ends = [start[parameter], row[parameter]], [start["wall_max"], row[column]]
                axis.plot(*ends, "-" if row["stable"] else "--", color=colour, lw=1.2, zorder=2)


def ends_at(start: Row, summary: dict[str, Any], parameter: str) -> list[Row]:
    """The end of the bifurcation's branch that is nearer to it."""
    rows = [row for row in summary["points"] if row["branch"] == start["branch"]]
    ends = [rows[0], rows[-1]] if rows else []

    def distance(row: Row) -> float:
        return abs(row[parameter] / start[parameter] - 1.0) + abs(row["wall_max"] / start["wall_max"] - 1.0)

    return sorted(ends, key=distance)[:1]


def draw_rates(axis: Axes, branches: Sequence[Sequence[Row]], parameter: str) -> None:
    """The leading growth rate of each symmetry sector."""
    sectors = list(dict.fromkeys(sector for rows in branches for row in rows for sector in row["growth_rates"]))
    for sector, colour in zip(sectors, SECTOR_COLOURS, strict=False):
        for number, rows in enumerate(branches):
            values, rates = [row[parameter] for row in rows], [row["growth_rates"][sector] for row in rows]
            label = f"{sector} perturbations" if number == 0 else None
            axis.plot(values, rates, "-", color=colour, lw=1.0, label=label)
    axis.axhline(0.0, color="0.7", lw=0.6, zorder=0)
    if sectors:
        axis.legend(fontsize=8)


def legend() -> Iterator[Line2D]:
    """What the lines mean."""
    yield Line2D([], [], color="black", label="largest")
    yield Line2D([], [], color="0.55", label="smallest")
    yield Line2D([], [], color="tab:blue", label="extended state")
    yield Line2D([], [], color="black", ls="--", label="unstable")
    yield Line2D([], [], color="black", marker="o", mfc="white", ls="", ms=5, label="fold")
    yield Line2D([], [], color="tab:blue", marker="s", mfc="white", ls="", ms=5, label="bifurcation")
