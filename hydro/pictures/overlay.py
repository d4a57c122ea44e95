"""Histories of runs over each other."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydro.observables.sets import Curve, Panel, error_of
from hydro.pictures.history import TIME
from hydro.pictures.style import literally, save

if TYPE_CHECKING:
    import pandas as pd

SETTLED = 0.05  # share of the rows that may lie below the axis: grains begin with few in a cell
LEAST = 0.1  # of a value, at which the band of its error ends: on a logarithmic axis
HUES = colormaps["tab10"].colors  # type: ignore[attr-defined]


def overlaid_histories(path: Path, panels: Sequence[Panel], runs: Sequence[tuple[str, pd.DataFrame]]) -> None:
    """Panels of the histories of runs, each with its name, against time; shaded: a standard error to each side."""
    heights = [panel.height for panel in panels]
    figure = Figure(figsize=(6.5, 1.875 * sum(heights)), layout="constrained")
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    for axis, panel in zip(axes, panels, strict=True):
        for number, (name, history) in enumerate(runs):
            for line, curve in enumerate(panel.curves):
                draw(axis, history, curve, HUES[number % len(HUES)], "" if line else literally(name))
        axis.set_yscale(panel.scale)
        axis.set_ylabel(panel.label)
    if panels[0].scale == "log":
        columns = [history[curve.column] for _, history in runs for curve in panels[0].curves]
        lows = [column[column > 0.0] for column in columns]
        axes[0].set_ylim(bottom=0.5 * min((float(np.quantile(low, SETTLED)) for low in lows if low.size), default=2.0))
    axes[-1].set_xlabel(TIME)
    legend = axes[0].get_legend_handles_labels()
    figure.legend(*legend, loc="outside upper center", ncols=min(len(runs), 3), fontsize=8)
    save(figure, path)


def draw(axis: Axes, history: pd.DataFrame, curve: Curve, hue: tuple[float, ...], label: str) -> None:
    """A column of a history, with its errors where they are known; a gap where it is zero."""
    time, column = history["time"], history[curve.column]
    values = column.where(column > 0.0)
    axis.plot(time, values, curve.dash, color=hue, linewidth=1.0, label=label or None)
    if error_of(curve.column) in history:
        error = history[error_of(curve.column)]
        low = np.maximum(values - error, LEAST * values)
        axis.fill_between(time, low, values + error, color=hue, alpha=0.2, lw=0.0)
