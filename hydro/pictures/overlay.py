"""Pictures of runs beside each other."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydro.pictures.density import Map, density_panels
from hydro.pictures.history import TIME
from hydro.pictures.style import literally, save

if TYPE_CHECKING:
    from hydro.runs.overlay import Overlaid

SETTLED = 0.05  # share of the rows that may lie below the axis: grains begin with few in a cell
HUES = colormaps["tab10"].colors  # type: ignore[attr-defined]


def overlaid_histories(path: Path, runs: Sequence[Overlaid]) -> None:
    """Wall densities, the density at x = 1 and mean x against time; shaded: a standard error to each side."""
    figure = Figure(figsize=(6.5, 7.5), layout="constrained")
    walls, gas, centre = figure.subplots(3, 1, sharex=True, height_ratios=(2, 1, 1))
    for number, run in enumerate(runs):
        hue = HUES[number % len(HUES)]
        curve(walls, run, "wall_max", hue, "-", literally(run.name))
        curve(walls, run, "wall_min", hue, "--")
        curve(gas, run, "gas_density", hue, "-")
        curve(centre, run, "centre_x", hue, "-")
    walls.set_yscale("log")
    walls.set_ylim(bottom=min(0.5 * float(np.quantile(run.history["wall_min"], SETTLED)) for run in runs) or None)
    gas.set_yscale("log")
    walls.set_ylabel("$n(0,y)/n_c$: largest (full),\nsmallest (dashed)")
    gas.set_ylabel("mean $n(1,y)/n_c$")
    centre.set_ylabel("mean $x/L_x$")
    centre.set_xlabel(TIME)
    figure.legend(*walls.get_legend_handles_labels(), loc="outside upper center", ncols=min(len(runs), 3), fontsize=8)
    save(figure, path)


def curve(axis: Axes, run: Overlaid, column: str, hue: tuple[float, ...], dash: str, label: str | None = None) -> None:
    """A column of a history, with its errors where they are known."""
    time, values = run.history["time"], run.history[column]
    there = values > 0.0
    axis.plot(time[there], values[there], dash, color=hue, linewidth=1.0, label=label)
    if f"{column}_error" in (run.history.dtype.names or ()):
        error = run.history[f"{column}_error"]
        known = there & (values > error)
        axis.fill_between(time[known], (values - error)[known], (values + error)[known], color=hue, alpha=0.2, lw=0.0)


def last_densities(path: Path, runs: Sequence[Overlaid]) -> None:
    """The last density of each run."""
    maps = []
    for run in runs:
        low, high = run.extremes
        maps.append(Map(run.density, run.mesh, f"{literally(run.name)}, $t={run.time:g}$", high, low))
    density_panels(path, maps)
