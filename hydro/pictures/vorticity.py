"""Maps of the vorticity: shear layers and vortices."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from string import ascii_lowercase

import numpy as np
from matplotlib.figure import Figure

from hydro.observables.cooling import mean_temperature, vorticity
from hydro.pictures.density import PANELS_IN_ROW
from hydro.pictures.style import save
from hydro.state import State


def vorticity_panels(path: Path, states: Sequence[State]) -> None:
    """The vorticity of each state over the root of its mean temperature, on a scale of its own; white is none."""
    columns = min(len(states), PANELS_IN_ROW)
    rows = math.ceil(len(states) / columns)
    figure = Figure(figsize=(3.2 * columns, 3.1 * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).ravel()
    for letter, axis, state in zip(ascii_lowercase, axes, states, strict=False):
        mesh, field = state.mesh, vorticity(state) / math.sqrt(mean_temperature(state, None))
        most = float(np.abs(field).max())
        shades = axis.pcolormesh(
            mesh.x_faces, mesh.y_faces, field.T, cmap="RdGy", vmin=-most, vmax=most, rasterized=True
        )
        axis.set_aspect("equal")
        axis.set_title(f"({letter})  $t={state.time:.4g}$", fontsize=10)
        figure.colorbar(shades, ax=axis, fraction=0.05, pad=0.03).ax.tick_params(labelsize=8)
    for unused in axes[len(states) :]:
        unused.remove()
    figure.supxlabel("$x/L_x$")
    figure.supylabel("$y/L_x$")
    save(figure, path)
