"""A run beside a steady state: distance against time, and maps of both with their difference."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydro.pictures.density import HEIGHT, drawn_ratio
from hydro.pictures.style import save
from hydro.state import State

COLOURS = ("tab:red", "tab:blue", "tab:green", "tab:purple")  # of symmetry sectors, those largest first
FLOOR = 1e-13  # smallest distance shown
FIELDS = (("density", "$n/n_c$"), ("temperature", "$T/T_*$"))


def distance_curves(path: Path, result: dict[str, Any], parts: np.ndarray) -> None:
    """Relative L2 distances against time on a logarithmic axis, with fitted rates and eigenvalues.

    result: as in compare.json. parts: distances by symmetry sector, (sectors, checkpoints).
    """
    figure = Figure(figsize=(4.8, 4.6), layout="constrained")
    axis = figure.add_subplot()
    rows, (total, *sectors) = result["checkpoints"], result["rates"]
    times = np.array([row["time"] for row in rows])
    curve(axis, times, [row["temperature"]["L2"] for row in rows], "temperature", color="0.6", marker="s")
    curve(axis, times, [row["density"]["L2"] for row in rows], named("density", total), color="black", marker="o")
    straight(axis, total, "black")
    shown = [k for k in np.argsort(-parts.max(axis=1)) if parts[k].max() > FLOOR][: len(COLOURS)] if sectors else []
    for k, colour in zip(shown, COLOURS, strict=False):
        curve(axis, times, parts[k], named(sectors[k]["sector"], sectors[k]), color=colour, marker=".")
        straight(axis, sectors[k], colour)
    axis.set_yscale("log")
    axis.set_xlabel("time $t\\,T_*^{1/2}/L_x$")
    axis.set_ylabel("distance from the steady state, $L_2$, relative")
    axis.legend(fontsize=8, loc="lower left", bbox_to_anchor=(0.0, 1.0))
    save(figure, path)


def curve(axis: Axes, times: np.ndarray, distances: Sequence[float], label: str, **look: Any) -> None:
    """One distance, without what is below all interest."""
    values = np.asarray(distances)
    axis.plot(times, np.where(values > FLOOR, values, np.nan), label=label, linewidth=0.8, markersize=3.0, **look)


def named(name: str, entry: dict[str, Any]) -> str:
    """A legend with the fitted rate and the eigenvalue."""
    fit, rate = entry["fit"], entry["growth_rate"]
    fitted = "no exponential stretch" if fit is None else f"rate {fit['rate']:.4g}"
    return f"{name}: {fitted}" + ("" if rate is None else f" (eigenvalue {rate:.4g})")


def straight(axis: Axes, entry: dict[str, Any], colour: str) -> None:
    """The fitted exponential over its stretch, as a wide band beneath the points."""
    fit = entry["fit"]
    if fit is not None:
        ends = np.array([fit["start"], fit["end"]])
        values = fit["at_start"] * np.exp(fit["rate"] * (ends - ends[0]))
        axis.plot(ends, values, color=colour, lw=6.0, alpha=0.2, zorder=0)


def difference_maps(path: Path, state: State, steady: State) -> None:
    """Density and temperature of a run, of the steady state, and the first less the second."""
    mesh, ratio = state.mesh, drawn_ratio(state.mesh)
    height = HEIGHT * min(1.0, max(ratio, 0.4))
    figure = Figure(figsize=(3 * (height / ratio + 1.1), 2 * (height + 0.6)), layout="constrained")
    for row, (field, label) in zip(figure.subplots(2, 3, sharey=True), FIELDS, strict=True):
        mine, there = getattr(state, field), getattr(steady, field)
        top, most = float(max(mine.max(), there.max())), float(np.abs(mine - there).max()) or 1.0
        panels = (
            (f"run, $t={state.time:g}$", mine, "gray_r", (0.0, top)),
            ("steady state", there, "gray_r", (0.0, top)),
            ("difference", mine - there, "RdBu_r", (-most, most)),
        )
        for axis, (title, values, colours, (low, high)) in zip(row, panels, strict=True):
            shades = axis.pcolormesh(
                mesh.x_faces, mesh.y_faces, values.T, cmap=colours, vmin=low, vmax=high, rasterized=True
            )
            axis.set_aspect(ratio / mesh.aspect_ratio)
            axis.set_xticks([0.0, 0.5, 1.0])
            axis.set_title(title, fontsize=10)
            scale = figure.colorbar(shades, ax=axis, fraction=0.08, pad=0.03, shrink=0.9)
            scale.set_label(label)
            scale.ax.tick_params(labelsize=8)
            scale.ax.ticklabel_format(axis="y", scilimits=(-2, 3))
        row[0].set_ylabel("$y/L_x$")
    for axis in figure.axes[3:6]:
        axis.set_xlabel("$x/L_x$")
    save(figure, path)
