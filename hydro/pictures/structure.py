"""Structure factors of density and velocity against the wave number."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from hydro.observables.cooling import structure
from hydro.pictures.style import save
from hydro.state import State


def structure_factors(path: Path, states: Sequence[State]) -> None:
    """Those of density and of velocity, a line for each state; later ones are darker, and the largest is marked."""
    figure = Figure(figsize=(7.5, 3.4), layout="constrained")
    density, velocity = figure.subplots(1, 2, sharex=True)
    shades = np.linspace(0.75, 0.0, len(states)) if len(states) > 1 else [0.0]
    for state, shade in zip(states, shades, strict=True):
        found, look = structure(state), {"color": str(shade), "linewidth": 1.1}
        k = found.wave_numbers
        density.loglog(k, found.density, label=f"$t={state.time:.4g}$", **look)
        velocity.loglog(k, found.across, **look)
        velocity.loglog(k, found.along, "--", **look)
        for axis, power in ((density, found.density), (velocity, np.maximum(found.across, found.along))):
            top = int(np.argmax(power))
            axis.plot(k[top], power[top], "o", color=str(shade), markersize=3.5)
    density.set_ylabel("of the density, over its mean squared")
    velocity.set_ylabel("of the velocity, over mean $T$")
    density.legend(fontsize=7, ncols=1 + len(states) // 7)
    velocity.plot([], [], "k-", label="across $k$: vortices")
    velocity.plot([], [], "k--", label="along $k$")
    velocity.legend(fontsize=7)
    for axis in (density, velocity):
        axis.set_xlabel("wave number $kL_x$")
    save(figure, path)
