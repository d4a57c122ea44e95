"""The look that all pictures share."""

from __future__ import annotations

import logging
from pathlib import Path

import matplotlib
from matplotlib.figure import Figure

from hydro.output.files import replacing

matplotlib.rcParams.update(
    {
        "font.family": "serif",
        "mathtext.fontset": "cm",
        "font.size": 10,
        "axes.linewidth": 0.7,
        "xtick.direction": "in",
        "ytick.direction": "in",
        "legend.frameon": False,
        "savefig.dpi": 160,
        "pdf.fonttype": 42,
    }
)

logging.getLogger("fontTools").setLevel(logging.ERROR)  # it talks about dates in fonts


def save(figure: Figure, path: Path, dpi: float | None = None) -> None:
    """Write `figure` to `path`, whole or not at all; the suffix picks the format, `dpi` another resolution."""
    with replacing(path) as temporary:
        figure.savefig(temporary, bbox_inches="tight", dpi=dpi)


def publish(figure: Figure, path: Path) -> None:
    """Write `figure` as `path`.png and, for print, as `path`.pdf; `path` has no suffix."""
    for suffix in (".png", ".pdf"):
        save(figure, path.with_name(path.name + suffix))


def literally(name: str) -> str:
    """A name of which nothing is taken for mathematics."""
    return name.replace("$", r"\$")
