"""Maps of eigenmodes: the relative change of the density, red where it grows denser, blue where thinner."""

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


def mode_panels(path: Path, state: State, modes: Sequence[Mode]) -> None:
    """Draw the modes of `state` side by side into `path`.png and `path`.pdf."""
    mesh = state.mesh
    ratio = drawn_ratio(mesh)
    columns = min(len(modes), PANELS_IN_ROW)
    rows = math.ceil(len(modes) / columns)
    height = HEIGHT * min(1.0, max(ratio, 0.4))
    figure = Figure(figsize=(columns * (height / ratio + 0.9), rows * (height + 0.9)), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for number, (axis, mode) in enumerate(zip(axes, modes, strict=False)):
        change = mode.density.real / state.density
        change = change / np.max(np.abs(change))
        axis.pcolormesh(mesh.x_faces, mesh.y_faces, change.T, cmap="RdBu_r", vmin=-1, vmax=1, rasterized=True)
        axis.set_aspect(ratio / mesh.aspect_ratio)
        rate = f"{mode.growth_rate.real:.3g}"
        axis.set_title(f"({ascii_lowercase[number]})  {mode.sector}\n$\\lambda={rate}$", fontsize=10)
        axis.set_xlabel("$x/L_x$")
        axis.set_xticks([0.0, 0.5, 1.0])
        if number % columns == 0:
            axis.set_ylabel("$y/L_x$")
    for unused in axes[len(modes) :]:
        unused.remove()
    publish(figure, path)
