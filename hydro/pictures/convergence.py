"""Errors against the size of cells or steps, on logarithmic axes."""

from __future__ import annotations

from itertools import groupby, pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydro.pictures.style import publish

MARKERS = "osv^Dx+*"
MOST_PANELS = 6

Curves = dict[str, tuple[np.ndarray, np.ndarray]]  # (sizes, errors) by the name of the variant


def draw(path: Path, summary: dict[str, Any], order: float) -> None:
    """Sums of the errors of a study of convergence, and changes of its scalars from level to level, with lines of slope
    `order`: `path`.png and `path`.pdf."""
    panels = [("sum of the errors", error_curves(summary["rows"]))]
    names = dict.fromkeys(entry["scalar"] for entry in summary["limits"])
    panels += [
        (f"{name}: change to the next level".replace("_", " "), changes(summary["rows"], name)) for name in names
    ]
    panels = [(label, curves) for label, curves in panels if curves][:MOST_PANELS]
    if not panels:
        return
    figure = Figure(figsize=(4.2 * len(panels), 3.8), layout="constrained")
    for axis, (label, curves) in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
        panel(axis, label, curves, order)
    publish(figure, path)


def error_curves(rows: list[dict[str, Any]]) -> Curves:
    """The sums of errors of every variant."""
    found = {}
    for name, ladder in groupby(rows, key=variant):
        found[name] = positive([(row["size"], row["errors"]["total"]) for row in ladder if row["errors"]["total"]])
    return {name: curve for name, curve in found.items() if curve[0].size}


def changes(rows: list[dict[str, Any]], scalar: str) -> Curves:
    """Changes of a scalar to the next finer level, of every variant."""
    found = {}
    for name, ladder in groupby(rows, key=variant):
        values = [(row["size"], row["scalars"][scalar]) for row in ladder]
        found[name] = positive([(size, abs(b - a)) for (size, a), (_, b) in pairwise(values) if None not in (a, b)])
    return {name: curve for name, curve in found.items() if curve[0].size}


def variant(entry: dict[str, Any]) -> str:
    """The variant that a row, or a limit, belongs to."""
    return ", ".join(map(str, entry["variant"].values()))


def positive(points: list[tuple[float, float]]) -> tuple[np.ndarray, np.ndarray]:
    """Sizes and errors, without errors that are zero."""
    table: np.ndarray = np.array([point for point in points if point[1] > 0.0]).reshape(-1, 2)
    return table[:, 0], table[:, 1]


def panel(axis: Axes, label: str, curves: Curves, order: float) -> None:
    """Curves of all variants, and a line of the expected slope below them."""
    for (name, (sizes, errors)), marker in zip(curves.items(), MARKERS * len(curves), strict=False):
        axis.loglog(sizes, errors, marker=marker, markersize=4.5, linewidth=1.1, label=name or None)
    every = np.unique(np.concatenate([sizes for sizes, _ in curves.values()]))
    below = 0.5 * min(float(np.min(errors / sizes**order)) for sizes, errors in curves.values())
    axis.loglog(every, below * every**order, color="0.6", linewidth=1.0, linestyle="--", label=f"order {order:g}")
    axis.set_xlabel("size of cells or steps, relative")
    axis.set_ylabel(label)
    axis.set_xticks(every, [fraction(size) for size in every], minor=False)
    axis.set_xticks([], minor=True)
    axis.legend(fontsize=8)


def fraction(size: float) -> str:
    """1, 1/2, 1/4 and the like, or a decimal."""
    inverse = round(1.0 / size)
    if abs(inverse * size - 1.0) > 1e-9:
        return f"{size:.3g}"
    return "1" if inverse == 1 else f"1/{inverse}"
