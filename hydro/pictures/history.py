"""Curves of a run against time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydro.observables.sets import Curve, Panel
from hydro.pictures.style import save

if TYPE_CHECKING:
    import pandas as pd


ABOVE: dict[str, Any] = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0), "ncols": 3}  # a legend outside the axes
TIME = "time $t\\,T_*^{1/2}/L_x$"


def history_curves(path: Path, history: pd.DataFrame, panels: Sequence[Panel]) -> None:
    """All panels, one above the other."""
    heights = [panel.height for panel in panels]
    figure = Figure(figsize=(6.0, 1.75 * sum(heights)), layout="constrained")
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    for axis, panel in zip(axes, panels, strict=True):
        curves(axis, history, panel.curves, **ABOVE)
        axis.set_ylabel(panel.label)
    axes[-1].set_xlabel(TIME)
    save(figure, path)


def history_panel(history: pd.DataFrame, panel: Panel) -> Figure:
    """One panel, as small as a page wants it."""
    figure = Figure(figsize=(4.4, 3.0), layout="constrained")
    axis = figure.add_subplot()
    curves(axis, history, panel.curves, **ABOVE)
    axis.set_ylabel(panel.label)
    axis.set_xlabel(TIME)
    return figure


def curves(axis: Axes, history: pd.DataFrame, columns: Sequence[Curve], **legend: Any) -> None:
    """Columns against time on a logarithmic axis; what is not positive is left out, and the axis spans a factor 2.

    legend: where it is and how it looks.
    """
    for column, label, dash in columns:
        there = history[column] > 0.0
        axis.semilogy(history["time"][there], history[column][there], dash, color="black", label=label)
    values = np.concatenate([history[column][history[column] > 0.0] for column, _, _ in columns])
    if values.size and values.max() < 2.0 * values.min():
        middle = np.sqrt(values.max() * values.min())
        axis.set_ylim(middle / np.sqrt(2.0), middle * np.sqrt(2.0))
    if any(label for _, label, _ in columns):
        axis.legend(fontsize=8, **legend)
    if not values.size:
        axis.text(0.5, 0.5, "zero at all times", transform=axis.transAxes, ha="center", va="center")
        axis.set_yticks([])
        axis.set_yticks([], minor=True)
