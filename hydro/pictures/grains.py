"""Grains drawn to scale in their vessel, coloured by speed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from hydro.grains.dynamics import Dynamics
from hydro.pictures.style import save

HEIGHT = 6.0  # inches
LIMITS = (0.25, 4.0)  # height over width, at most
FASTEST = 99.0  # percentile of speeds at which the colours end
PIXELS = 5.0  # across a grain, while the picture stays within its resolution
RESOLUTION = (150, 400)  # dots per inch


def draw(path: Path, grains: Dynamics) -> None:
    """All grains at the present time. Where the box has walls, the vessel is wider than it by a diameter."""
    box, radius = grains.arena, 0.5 * grains.arena.diameter
    positions, lengths = grains.positions, (1.0, box.length_y)
    margins = [0.0 if periodic else radius for periodic in (box.periodic_x, box.periodic_y)]
    for axis_number, (length, margin) in enumerate(zip(lengths, margins, strict=True)):
        if margin == 0.0:
            positions[:, axis_number] %= length
    shape = min(max(box.length_y, LIMITS[0]), LIMITS[1])
    figure = Figure(figsize=(HEIGHT / max(shape, 1.0) + 1.5, HEIGHT * min(shape, 1.0) + 0.6), layout="constrained")
    axis = figure.add_subplot()
    disks = disks_at(positions, np.hypot(*grains.velocities.T), box.diameter)
    disks.set_offset_transform(axis.transData)
    axis.add_collection(disks)
    corner, size = (-margins[0], -margins[1]), (1.0 + 2.0 * margins[0], box.length_y + 2.0 * margins[1])
    axis.add_patch(Rectangle(corner, *size, fill=False, linewidth=0.8))
    axis.set_xlim(-2.0 * radius, 1.0 + 2.0 * radius)
    axis.set_ylim(-2.0 * radius, box.length_y + 2.0 * radius)
    axis.set_aspect("equal")
    axis.set_xlabel("$x/L_x$")
    axis.set_ylabel("$y/L_x$")
    axis.set_title(f"{grains.number} grains, $t = {grains.time:g}$", fontsize=10)
    figure.colorbar(disks, ax=axis, fraction=0.06, pad=0.02, extend="max", label="speed$/T_*^{1/2}$")
    wanted = PIXELS / box.diameter * max(lengths) / HEIGHT
    save(figure, path, min(max(wanted, RESOLUTION[0]), RESOLUTION[1]))


def disks_at(positions: np.ndarray, speeds: np.ndarray, diameter: float) -> EllipseCollection:
    """Disks to scale, with the colours of their speeds."""
    sizes = np.full(len(positions), diameter)
    disks = EllipseCollection(
        sizes, sizes, np.zeros_like(sizes), units="xy", offsets=positions, array=speeds, cmap="plasma", linewidth=0.0
    )
    disks.set_clim(0.0, float(np.percentile(speeds, FASTEST)))
    return disks
