"""Marginal stability curves: the tongues of one L like Fig. 2 of the paper, or the curves of several L like Fig. 1."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import LogLocator, NullFormatter
from scipy.interpolate import CubicSpline

from hydro.pictures.style import publish

DASHES = ("-", (0, (5, 2)), (0, (6, 2, 1, 2)), (0, (8, 2, 3, 2)))  # of m = 1, 2, 3, and more
DOTS, SPARSE_DOTS = (0, (1, 1.5)), (0, (1, 4))  # of the thermal wall, m = 1 and more
HEADROOM = 5.0  # how far above its least value a tongue is shown
DECADES = 1.8  # how much of the curves of several L is shown
ENOUGH = 20  # points of a curve from which it is drawn smooth; fewer are marked one by one
FINE = 2000  # points of a smooth curve

Rows = Sequence[dict[str, Any]]


def draw(path: Path, rows: Rows, tongues: Rows, points: Sequence[tuple[float, float, str]] = ()) -> None:
    """Draw what a stability deck has found, as `path`.png and `path`.pdf.

    `rows` and `tongues` are those of its summary; `points` are (f, aspect ratio, label).
    """
    single = len({row["L"] for row in rows}) == 1
    figure = Figure(figsize=(5.2, 4.0), layout="constrained")
    axis = figure.add_subplot()
    if all(row["aspect_ratio"] is None for row in rows):
        axis.text(0.5, 0.5, "stable for every aspect ratio", transform=axis.transAxes, ha="center")
        axis.set_axis_off()
    elif single:
        one_loss(axis, rows, tongues, points)
    else:
        several_losses(axis, rows, tongues)
    publish(figure, path)


def one_loss(axis: Axes, rows: Rows, tongues: Rows, points: Sequence[tuple[float, float, str]]) -> None:
    """Tongues of one L: aspect ratio against area fraction, points marked."""
    for wall in distinct(rows, "wall"):
        for m in distinct(rows, "m"):
            label = f"$m={m}$" if wall == "vibrating" else f"$m={m}$, {wall} wall"
            shade = "black" if wall == "vibrating" or m == 1 else "0.4"
            curve = Curve.of(rows, tongues, rows[0]["L"], wall, m)
            curve.draw(axis, linestyle=dash(wall, m), color=shade, linewidth=1.2, label=label)
    for f, ratio, label in points:
        axis.plot(f, ratio, "o", color="black", markersize=4.5, zorder=3)
        text = axis.annotate(label, (f, ratio), (5, 4), textcoords="offset points", zorder=4)
        text.set_path_effects([withStroke(linewidth=3.0, foreground="white")])
    least = min(row["aspect_ratio"] for row in rows if row["aspect_ratio"] is not None)
    axis.set_ylim(0.0, max([HEADROOM * least, *(1.5 * ratio for _, ratio, _ in points)]))
    axis.set_xlim(0.0, 1.05 * max(row["f"] for row in rows))
    axis.set_xlabel("area fraction $f$")
    axis.set_ylabel(r"aspect ratio $\Delta$")
    axis.xaxis.set_major_formatter("{x:g}")
    axis.set_title(rf"$\mathcal{{L}}={power(rows[0]['L'])}$", fontsize=10)
    axis.legend(fontsize=9)


def several_losses(axis: Axes, rows: Rows, tongues: Rows) -> None:
    """Delta_1 L^(1/2) against area fraction, one curve for each L."""
    losses = sorted(distinct(rows, "L"))
    shades = matplotlib.colormaps["viridis"](np.linspace(0.0, 0.85, len(losses)))
    first = min(distinct(rows, "m"))
    for L, shade in zip(losses, shades.tolist(), strict=True):
        for wall in distinct(rows, "wall"):
            label = rf"$\mathcal{{L}}={power(L)}$" + ("" if wall == "vibrating" else f", {wall} wall")
            curve = Curve.of(rows, tongues, L, wall, first).scaled(math.sqrt(L))
            curve.draw(axis, linestyle=dash(wall, 1), color=shade, linewidth=1.3, label=label)
    least = min(row["aspect_ratio"] * math.sqrt(row["L"]) for row in rows if row["aspect_ratio"] and row["m"] == first)
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.set_xlim(0.95 * min(row["f"] for row in rows), 1.05 * max(row["f"] for row in rows))
    axis.set_ylim(0.8 * least, 10.0**DECADES * least)
    axis.legend(fontsize=8)
    axis.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.yaxis.set_major_formatter("{x:.0f}")
    axis.yaxis.set_minor_formatter(NullFormatter())
    axis.set_xlabel("area fraction $f$")
    axis.set_ylabel(rf"$\Delta_{{{first}}}\,\mathcal{{L}}^{{1/2}}$")


class Curve(NamedTuple):
    """One curve: (f, Delta_m) where that is finite, increasing in f, and the ends f1, f2 where it is not, if known."""

    f: np.ndarray
    ratio: np.ndarray
    ends: tuple[float, ...] = ()

    @classmethod
    def of(cls, rows: Rows, tongues: Rows, L: float, wall: str, m: int) -> Curve:
        """The curve of one L, wall and m."""
        points = sorted(
            (row["f"], row["aspect_ratio"]) for row in rows
            if (row["L"], row["wall"], row["m"]) == (L, wall, m) and row["aspect_ratio"] is not None
        )  # fmt: skip
        ends = [
            (tongue["f1"], tongue["f2"]) for tongue in tongues
            if (tongue["L"], tongue["wall"]) == (L, wall) and tongue["f1"] is not None
        ]  # fmt: skip
        table: np.ndarray = np.array(points).reshape(-1, 2)
        return cls(table[:, 0], table[:, 1], ends[0] if ends else ())

    def scaled(self, factor: float) -> Curve:
        """The same with Delta_m times a factor."""
        return self._replace(ratio=factor * self.ratio)

    def draw(self, axis: Axes, **look: Any) -> None:
        """Draw it. Many points are joined by a spline of 1/Delta_m^2, which is smooth and zero at the ends."""
        if self.f.size == 0:
            return
        if self.f.size < ENOUGH:
            axis.plot(self.f, self.ratio, marker="o", markersize=3.0, **look)
            return
        inside = [(math.log(end), 0.0) for end in self.ends]
        u, value = np.array(sorted([*zip(np.log(self.f), self.ratio**-2.0, strict=True), *inside])).T
        ends = np.cos(np.linspace(math.pi, 0.0, FINE + 1)[1:-1])  # points crowd where the curve turns upward
        fine = 0.5 * (u[0] + u[-1] + (u[-1] - u[0]) * ends)
        smooth = CubicSpline(u, value)(fine)
        axis.plot(np.exp(fine[smooth > 0.0]), smooth[smooth > 0.0] ** -0.5, **look)


def dash(wall: str, m: int) -> Any:
    """Solid, dashed and so on by m for the vibrating wall, dotted for the thermal one."""
    if wall == "vibrating":
        return DASHES[min(m, len(DASHES)) - 1]
    return DOTS if m == 1 else SPARSE_DOTS


def distinct(rows: Rows, key: str) -> list[Any]:
    """The values of a column, each once, in the order in which they come."""
    return list(dict.fromkeys(row[key] for row in rows))


def power(L: float) -> str:
    """A number for print: 5 10^4."""
    exponent = math.floor(math.log10(L))
    factor = L / 10.0**exponent
    if exponent < 3:
        return f"{L:g}"
    return f"10^{{{exponent}}}" if math.isclose(factor, 1.0) else rf"{factor:.3g}\cdot 10^{{{exponent}}}"
