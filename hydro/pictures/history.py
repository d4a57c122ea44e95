"""Curves of a run against time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from hydro.pictures.style import save


def history_curves(path: Path, history: np.ndarray) -> None:
    """Wall extremes and gas density above, the flow's largest Mach number below; `history` is a record array."""
    figure = Figure(figsize=(6.0, 5.0), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    for column, label, dash in (
        ("wall_max", "largest on the wall $x=0$", "-"),
        ("wall_min", "smallest on the wall $x=0$", "--"),
        ("gas_density", "mean at the wall $x=1$", ":"),
    ):
        above.semilogy(history["time"], history[column], dash, color="black", label=label)
    above.set_ylabel("density $n/n_c$")
    above.legend()
    moving = history["max_mach"] > 0.0
    below.semilogy(history["time"][moving], history["max_mach"][moving], color="black")
    below.set_ylabel("largest Mach number")
    below.set_xlabel("time $t\\,T_*^{1/2}/L_x$")
    save(figure, path)
