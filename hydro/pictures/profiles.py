"""Profiles across the box: fields averaged over y, against x."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from hydro.pictures.style import save
from hydro.state import State

FIELDS = (
    ("density $n/n_c$", lambda state: state.density),
    ("temperature $T/T_*$", lambda state: state.temperature),
    ("pressure $p/(n_c T_*)$", lambda state: state.pressure),
    ("velocity $u/T_*^{1/2}$", lambda state: state.velocity[0]),
)


def profiles(path: Path, states: Sequence[State]) -> None:
    """Density, temperature, pressure and velocity along x, one line for each state; later ones are darker."""
    figure = Figure(figsize=(7.5, 5.5), layout="constrained")
    axes = figure.subplots(2, 2, sharex=True).ravel()
    shades = np.linspace(0.7, 0.0, len(states)) if len(states) > 1 else [0.0]
    for axis, (label, field) in zip(axes, FIELDS, strict=True):
        for state, shade in zip(states, shades, strict=True):
            mean = field(state) @ state.mesh.dy / state.mesh.aspect_ratio
            axis.plot(state.mesh.x, mean, color=str(shade), label=f"$t={state.time:g}$", linewidth=1.1)
        axis.set_ylabel(label)
        axis.set_xlim(0.0, 1.0)
    for axis in axes[2:]:
        axis.set_xlabel("$x/L_x$, averages over $y$")
    axes[1].legend(fontsize=8)
    save(figure, path)
