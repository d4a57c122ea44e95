"""Grains drawn to scale in their vessel, coloured by speed or by cluster."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from hydro.choices import GRAIN_COLOURS
from hydro.grains.clusters import clusters
from hydro.grains.dynamics import Dynamics
from hydro.pictures.style import save

HEIGHT = 6.0  # inches
LIMITS = (0.25, 4.0)  # height over width, at most
FASTEST = 99.0  # percentile of speeds at which the colours end
PIXELS = 5.0  # across a grain, while the picture stays within its resolution
RESOLUTION = (150, 400)  # dots per inch
LEAST = 0.01  # of all grains, in a cluster with a colour of its own
HUES = colormaps["tab10"].colors[:7]  # type: ignore[attr-defined]
GREY = (0.5, 0.5, 0.5)  # of all other grains


def draw(path: Path, grains: Dynamics, colour: str) -> None:
    """All grains at the present time, in one of the ways to colour them that GRAIN_COLOURS lists."""
    length_y = grains.arena.length_y
    shape = min(max(length_y, LIMITS[0]), LIMITS[1])
    figure = Figure(figsize=(HEIGHT / max(shape, 1.0) + 1.5, HEIGHT * min(shape, 1.0) + 0.6), layout="constrained")
    show(figure.add_subplot(), grains, colour)
    wanted = PIXELS / grains.arena.diameter * max(1.0, length_y) / HEIGHT
    save(figure, path, min(max(wanted, RESOLUTION[0]), RESOLUTION[1]))


def show(axis: Axes, grains: Dynamics, colour: str) -> None:
    """The same on an axis. Where the box has walls, the vessel is wider than it by a diameter."""
    box, radius = grains.arena, 0.5 * grains.arena.diameter
    disks = disks_at(grains.places, box.diameter)
    disks.set_offset_transform(axis.transData)
    axis.add_collection(disks)
    beyond_x, beyond_y = (0.0 if periodic else radius for periodic in (box.periodic_x, box.periodic_y))
    size = (1.0 + 2.0 * beyond_x, box.length_y + 2.0 * beyond_y)
    axis.add_patch(Rectangle((-beyond_x, -beyond_y), *size, fill=False, linewidth=0.8))
    axis.set_xlim(-2.0 * radius, 1.0 + 2.0 * radius)
    axis.set_ylim(-2.0 * radius, box.length_y + 2.0 * radius)
    axis.set_aspect("equal")
    axis.set_xlabel("$x/L_x$")
    axis.set_ylabel("$y/L_x$")
    axis.set_title(f"{grains.number} grains, $t = {grains.time:g}$", fontsize=10)
    GRAIN_COLOURS[colour](axis, disks, grains)


def disks_at(positions: np.ndarray, diameter: float) -> EllipseCollection:
    """Disks to scale."""
    sizes = np.full(len(positions), diameter)
    return EllipseCollection(sizes, sizes, np.zeros_like(sizes), units="xy", offsets=positions, linewidth=0.0)


def by_speed(axis: Axes, disks: EllipseCollection, grains: Dynamics) -> None:
    """Colour disks by the speed of grains, with a colour bar."""
    speeds = np.hypot(*grains.velocities.T)
    disks.set(array=speeds, cmap="plasma", clim=(0.0, float(np.percentile(speeds, FASTEST))))
    axis.figure.colorbar(disks, ax=axis, fraction=0.06, pad=0.02, extend="max", label="speed$/T_*^{1/2}$")


def by_cluster(axis: Axes, disks: EllipseCollection, grains: Dynamics) -> None:
    """Colour disks of the largest clusters, as many as there are HUES, and list how many grains each has."""
    rank = clusters(grains)
    counts = np.bincount(rank)[: len(HUES)]
    large = counts[counts >= max(LEAST * grains.number, 2)]
    palette = np.array([*HUES[: large.size], GREY])
    disks.set_facecolor(palette[np.minimum(rank, large.size)])
    names = [f"{count}" for count in large]
    if others := grains.number - large.sum():
        names.append(f"{others}, others")
    dots = [Line2D([], [], linestyle="", marker="o", color=hue) for hue in palette[: len(names)]]
    axis.legend(dots, names, loc="upper left", bbox_to_anchor=(1.0, 1.0), title="grains in clusters")
