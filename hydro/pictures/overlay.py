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
    from hydro.compare.overlay import Overlaid

SETTLED = 0.05  # share of the rows that may lie below the axis: grains begin with few in a cell
LEAST = 0.1  # of a value, at which the band of its error ends: on a logarithmic axis
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
    lows = [run.history[column][run.history[column] > 0.0] for run in runs for column in ("wall_min", "wall_max")]
    walls.set_ylim(bottom=0.5 * min((float(np.quantile(low, SETTLED)) for low in lows if low.size), default=2.0))
    gas.set_yscale("log")
    walls.set_ylabel("$n(0,y)/n_c$: largest (full),\nsmallest (dashed)")
    gas.set_ylabel("mean $n(1,y)/n_c$")
    centre.set_ylabel("mean $x/L_x$")
    centre.set_xlabel(TIME)
    figure.legend(*walls.get_legend_handles_labels(), loc="outside upper center", ncols=min(len(runs), 3), fontsize=8)
    save(figure, path)


def curve(axis: Axes, run: Overlaid, column: str, hue: tuple[float, ...], dash: str, label: str | None = None) -> None:
    """A column of a history, with its errors where they are known; a gap where it is zero."""
    time = run.history["time"]
    values = np.where(run.history[column] > 0.0, run.history[column], np.nan)
    axis.plot(time, values, dash, color=hue, linewidth=1.0, label=label)
    if f"{column}_error" in (run.history.dtype.names or ()):
        error = run.history[f"{column}_error"]
        low = np.maximum(values - error, LEAST * values)
        axis.fill_between(time, low, values + error, color=hue, alpha=0.2, lw=0.0)


def last_densities(path: Path, runs: Sequence[Overlaid]) -> None:
    """The last density of each run."""
    maps = []
    for run in runs:
        low, high = run.extremes
        maps.append(Map(run.density, run.mesh, f"{literally(run.name)}, $t={run.time:g}$", high, low))
    density_panels(path, maps)
