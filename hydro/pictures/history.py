"""Curves of a run against time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydro.pictures.style import save

WALLS = (
    ("wall_max", "largest on the wall $x=0$", "-"),
    ("wall_min", "smallest on the wall $x=0$", "--"),
    ("gas_density", "mean at the wall $x=1$", ":"),
)
ENERGIES = (("thermal_energy", "of random motion", "-"), ("kinetic_energy", "of the flow", "--"))


def history_curves(path: Path, history: np.ndarray) -> None:
    """Densities at the walls, energies, and the flow's largest Mach number; `history` is a record array."""
    figure = Figure(figsize=(6.0, 7.0), layout="constrained")
    axes = figure.subplots(3, 1, sharex=True, height_ratios=(2, 1, 1))
    curves(axes[0], history, WALLS)
    curves(axes[1], history, ENERGIES)
    curves(axes[2], history, (("max_mach", "", "-"),))
    for axis, label in zip(axes, ("density $n/n_c$", "energy $/(n_cT_*L_x^2)$", "largest Mach number"), strict=True):
        axis.set_ylabel(label)
    axes[2].set_xlabel("time $t\\,T_*^{1/2}/L_x$")
    save(figure, path)


def curves(axis: Axes, history: np.ndarray, columns: Sequence[tuple[str, str, str]]) -> None:
    """Columns against time on a logarithmic axis; what is not positive is left out, and the axis spans a factor 2."""
    for column, label, dash in columns:
        there = history[column] > 0.0
        axis.semilogy(history["time"][there], history[column][there], dash, color="black", label=label)
    values = np.concatenate([history[column][history[column] > 0.0] for column, _, _ in columns])
    if values.size and values.max() < 2.0 * values.min():
        middle = np.sqrt(values.max() * values.min())
        axis.set_ylim(middle / np.sqrt(2.0), middle * np.sqrt(2.0))
    if any(label for _, label, _ in columns):
        axis.legend(fontsize=8)
    if not values.size:
        axis.text(0.5, 0.5, "zero at all times", transform=axis.transAxes, ha="center", va="center")
        axis.set_yticks([])
        axis.set_yticks([], minor=True)
