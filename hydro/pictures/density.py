"""Gray-scale maps of the density, laid out like Fig. 4 of the paper: dense is dark, each with its own scale."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from string import ascii_lowercase
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydro.mesh import Mesh
from hydro.pictures.style import publish, save

PANELS_IN_ROW = 4
SLENDER = 6.0  # aspect ratios beyond this, or its inverse, are not drawn to scale
HEIGHT = 3.4  # of a panel whose box is taller than wide, in inches


class Map(NamedTuple):
    """What a panel shows: the density (nx, ny) on its mesh, a title above and a note below."""

    density: np.ndarray
    mesh: Mesh
    title: str
    note: str


def density_panels(path: Path, maps: Sequence[Map]) -> None:
    """Draw `maps` side by side into one picture at `path`; without a suffix, as PNG and PDF."""
    ratios = [drawn_ratio(panel.mesh) for panel in maps]
    columns = min(len(maps), PANELS_IN_ROW)
    rows = math.ceil(len(maps) / columns)
    height = HEIGHT * min(1.0, max(*ratios, 0.4))
    widths = [height / ratio + 1.0 for ratio in ratios[:columns]]
    figure = Figure(figsize=(sum(widths), rows * (height + 0.75)), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, width_ratios=widths).ravel()
    for number, (letter, axis, panel) in enumerate(zip(ascii_lowercase, axes, maps, strict=False)):
        draw(axis, panel, f"({letter})  " if len(maps) > 1 else "")
        if number % columns == 0:
            axis.set_ylabel("$y/L_x$")
    for unused in axes[len(maps) :]:
        unused.remove()
    (save if path.suffix else publish)(figure, path)


def drawn_ratio(mesh: Mesh) -> float:
    """Height over width of a map: that of the box, unless it is too slender to be seen to scale."""
    return min(max(mesh.aspect_ratio, 1.0 / SLENDER), SLENDER)


def draw(axis: Axes, panel: Map, label: str = "") -> None:
    """One density map with its scale."""
    mesh = panel.mesh
    shades = axis.pcolormesh(mesh.x_faces, mesh.y_faces, panel.density.T, cmap="gray_r", vmin=0.0, rasterized=True)
    axis.set_aspect(drawn_ratio(mesh) / mesh.aspect_ratio)
    axis.set_xticks([0.0, 0.5, 1.0])
    axis.set_title(label + panel.title, fontsize=10)
    axis.set_xlabel(f"$x/L_x$\n{panel.note}")
    scale = axis.figure.colorbar(shades, ax=axis, fraction=0.08, pad=0.03, shrink=0.9)
    scale.set_label("$n/n_c$")
    scale.ax.tick_params(labelsize=8)
