"""Curves of a run against time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydro.pictures.style import save


class Panel(NamedTuple):
    """Curves that share an axis: what it shows, its label, and (column, name, dash) of each curve."""

    words: str
    label: str
    columns: Sequence[tuple[str, str, str]]


WALLS = (
    ("wall_max", "largest, $x=0$", "-"),
    ("wall_min", "smallest, $x=0$", "--"),
    ("gas_density", "mean, $x=1$", ":"),
)
ENERGIES = (("thermal_energy", "of random motion", "-"), ("kinetic_energy", "of the flow", "--"))
PANELS = (
    Panel("Densities at the walls", "density $n/n_c$", WALLS),
    Panel("Energies", "energy $/(n_cT_*L_x^2)$", ENERGIES),
    Panel("The flow's largest Mach number", "largest Mach number", (("max_mach", "", "-"),)),
)
ABOVE: dict[str, Any] = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0), "ncols": 3}  # a legend outside the axes
TIME = "time $t\\,T_*^{1/2}/L_x$"


def history_curves(path: Path, history: np.ndarray) -> None:
    """All panels, one above the other; `history` is a table of named columns, a record array or a DataFrame."""
    figure = Figure(figsize=(6.0, 7.0), layout="constrained")
    axes = figure.subplots(len(PANELS), 1, sharex=True, height_ratios=(2, 1, 1))
    for axis, panel in zip(axes, PANELS, strict=True):
        curves(axis, history, panel.columns, **ABOVE)
        axis.set_ylabel(panel.label)
    axes[-1].set_xlabel(TIME)
    save(figure, path)


def history_panel(history: np.ndarray, panel: Panel) -> Figure:
    """One panel, as small as a page wants it."""
    figure = Figure(figsize=(4.4, 3.0), layout="constrained")
    axis = figure.add_subplot()
    curves(axis, history, panel.columns, **ABOVE)
    axis.set_ylabel(panel.label)
    axis.set_xlabel(TIME)
    return figure


def curves(axis: Axes, history: np.ndarray, columns: Sequence[tuple[str, str, str]], **legend: Any) -> None:
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
