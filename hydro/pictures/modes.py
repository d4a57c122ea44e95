"""Maps of eigenmodes: the relative change of the density, red where one gets denser, blue where thinner."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from string import ascii_lowercase

import numpy as np
from matplotlib.figure import Figure

from hydro.pictures.density import HEIGHT, PANELS_IN_ROW, drawn_ratio
from hydro.pictures.style import publish
from hydro.state import State
from hydro.steady.spectrum import Mode

MOST_PANELS = 12
NARROWEST = 1.8  # of a panel with its title, in inches


def mode_panels(path: Path, state: State, modes: Sequence[Mode]) -> None:
    """Draw the modes of `state` into `path`.png and `path`.pdf, those of largest growth rate if there are many."""
    mesh = state.mesh
    shown = sorted(modes, key=lambda mode: -mode.growth_rate.real)[:MOST_PANELS]
    modes = [mode for mode in modes if mode in shown]
    ratio = drawn_ratio(mesh)
    columns = min(len(modes), PANELS_IN_ROW)
    rows = math.ceil(len(modes) / columns)
    height = HEIGHT * min(1.0, max(ratio, 0.4))
    figure = Figure(
        figsize=(columns * max(height / ratio + 0.9, NARROWEST), rows * (height + 0.9)), layout="constrained"
    )
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for number, (axis, mode) in enumerate(zip(axes, modes, strict=False)):
        change = mode.density.real / state.density
        change = change / np.max(np.abs(change))
        shades = axis.pcolormesh(mesh.x_faces, mesh.y_faces, change.T, cmap="RdBu_r", vmin=-1, vmax=1, rasterized=True)
        axis.set_aspect(ratio / mesh.aspect_ratio)
        rate = f"{mode.growth_rate.real:.3g}"
        letter = f"({ascii_lowercase[number]})  " if len(modes) > 1 else ""
        sector = "all perturbations" if mode.sector == "all" else mode.sector
        axis.set_title(f"{letter}{sector}\n$\\lambda L_x/T_*^{{1/2}}={rate}$", fontsize=10)
        axis.set_xlabel("$x/L_x$")
        axis.set_xticks([0.0, 0.5, 1.0])
        if number % columns == 0:
            axis.set_ylabel("$y/L_x$")
    for unused in axes[len(modes) :]:
        unused.remove()
    scale = figure.colorbar(shades, ax=axes[: len(modes)].tolist(), fraction=0.08 / columns, pad=0.02, shrink=0.8)
    scale.set_label("$\\delta n/n$, over its largest value")
    scale.ax.tick_params(labelsize=8)
    publish(figure, path)
