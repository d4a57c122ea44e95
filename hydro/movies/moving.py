"""The density in motion: a map like those of the pictures, and under it the extremes that it tells against time.

A picture is drawn once; from moment to moment only what moves is drawn anew.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np
import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

from hydro.choices import SCALES
from hydro.deck.evolution import Movie
from hydro.mesh import Mesh
from hydro.observables.sets import Span
from hydro.pictures.density import drawn_ratio
from hydro.pictures.history import curves
from hydro.pictures.style import literally

MAPS = {"gray": "gray_r"}  # colours that matplotlib knows by another name
NARROWEST = 1e-3  # relative distance of the ends of a logarithmic scale

# Pixels. A resolution that is a power of two makes inches of them without rounding.
DPI = 128
SIDE = 512  # the longest side of the map
LEFT, RIGHT, TOP, BOTTOM = 92, 96, 70, 66  # margins of the map
GAP, BAR, SPACE = 10, 14, 4  # between map and colour scale, the width of that, and a space between words
NAME = 36  # height of the name of one picture among others
TRACE, EDGE, WIDTH = 150, 28, 480  # height and right margin of the curves; least width of the picture


class Moment(NamedTuple):
    """What is to be seen: a time, the density of shape (nx, ny), and its extremes."""

    time: float
    density: np.ndarray
    low: float
    high: float


class Part(Protocol):
    """A part of the picture; `moving` is what of it changes."""

    moving: list[Artist]

    def show(self, moment: Moment) -> None: ...


class MovingPicture:
    """The density map, its colour scale and time and, if a history is given, the curves under it.

    span: the extremes that are told. limits: ends of the scale; those of each moment when None. history: table of the
    run with the column `time` and those of the span. digits: of the time, after the point. size: width and height in
    pixels, even.
    """

    def __init__(
        self,
        mesh: Mesh,
        span: Span,
        look: Movie,
        limits: tuple[float, float] | None,
        history: pd.DataFrame | None,
        digits: int,
    ):
        ratio = drawn_ratio(mesh)
        width, height = (2 * round(0.5 * SIDE * min(share, 1.0)) for share in (1.0 / ratio, ratio))
        below = BOTTOM + (0 if history is None else TRACE + BOTTOM)
        self.mesh, self.span, self.size = mesh, span, (max(LEFT + width + RIGHT, WIDTH), below + height + TOP)
        self.figure = Figure(figsize=(self.size[0] / DPI, self.size[1] / DPI), dpi=DPI)
        left = LEFT + (self.size[0] - LEFT - width - RIGHT) // 2
        axes, bar = self._axes(left, below, width, height), self._axes(left + width + GAP, below, BAR, height)
        self.parts: list[Part] = [Map(axes, bar, mesh, look, limits), Header(self.figure, span, digits)]
        if history is not None:
            self.parts.append(Curves(self._axes(LEFT, BOTTOM, self.size[0] - LEFT - EDGE, TRACE), span, history))
        self.moving = [artist for part in self.parts for artist in part.moving]
        for artist in self.moving:
            artist.set_animated(True)
        self.canvas = FigureCanvasAgg(self.figure)
        self.canvas.draw()
        self.still = self.canvas.copy_from_bbox(self.figure.bbox)

    def _axes(self, left: int, bottom: int, width: int, height: int) -> Axes:
        across, up = self.size
        return self.figure.add_axes((left / across, bottom / up, width / across, height / up))

    def at(self, time: float, density: np.ndarray) -> np.ndarray:
        """The picture of a density, shape (nx, ny), at a time: RGBA bytes, shape (height, width, 4).

        The next one takes its place in the same array.
        """
        moment = Moment(time, density, *self.span.of(density, self.mesh))
        for part in self.parts:
            part.show(moment)
        self.canvas.restore_region(self.still)
        for artist in self.moving:
            self.figure.draw_artist(artist)
        return np.asarray(self.canvas.buffer_rgba())


class Board:
    """Pictures side by side, each under a name. size: width and height in pixels; pixels: (height, width, 4), RGBA."""

    def __init__(self, names: Sequence[str], sizes: Sequence[tuple[int, int]]):
        widths, heights = zip(*sizes, strict=True)
        self.size = sum(widths), NAME + max(heights)
        self.pixels = np.full((self.size[1], self.size[0], 4), 255, np.uint8)
        self.lefts = np.cumsum([0, *widths[:-1]])
        for name, left, width in zip(names, self.lefts, widths, strict=True):
            figure = Figure(figsize=(width / DPI, NAME / DPI), dpi=DPI)
            canvas = FigureCanvasAgg(figure)
            figure.text(0.5, 0.2, literally(name), ha="center", va="baseline")
            canvas.draw()
            self.pixels[:NAME, left : left + width] = canvas.buffer_rgba()

    def put(self, number: int, frame: np.ndarray) -> None:
        """Show another picture in a place."""
        left = self.lefts[number]
        self.pixels[NAME : NAME + frame.shape[0], left : left + frame.shape[1]] = frame


class Map:
    """The density, each pixel the average over what it covers, with its scale."""

    def __init__(self, axes: Axes, bar: Axes, mesh: Mesh, look: Movie, limits: tuple[float, float] | None):
        self.mesh, self.scale, self.limits = mesh, look.scale, limits
        width, height = round(axes.bbox.width), round(axes.bbox.height)
        self.pixels = np.linspace(0.0, 1.0, width + 1), np.linspace(0.0, mesh.aspect_ratio, height + 1)
        self.image = axes.imshow(
            np.ones((height, width)),
            cmap=MAPS.get(look.colours, look.colours),
            norm=SCALES[look.scale](*(limits or (0.1, 1.0))),
            extent=(0.0, 1.0, 0.0, mesh.aspect_ratio),
            origin="lower",
            interpolation="nearest",
            aspect="auto",
        )
        axes.tick_params(direction="out", labelsize=8)
        axes.set_xticks([0.0, 0.5, 1.0])
        axes.set_xlabel("$x/L_x$")
        axes.set_ylabel("$y/L_x$")
        axes.figure.colorbar(self.image, cax=bar)
        bar.tick_params(labelsize=8)
        bar.set_title("$n/n_c$", fontsize=10)
        self.moving: list[Artist] = [self.image, *axes.spines.values(), bar.yaxis]

    def show(self, moment: Moment) -> None:
        along_x = averages(moment.density, self.mesh.x_faces, self.pixels[0])
        self.image.set_data(averages(along_x.T, self.mesh.y_faces, self.pixels[1]))
        self.image.set_clim(*(self.limits or ends(moment.density, self.scale)))


class Header:
    """The time, and the extremes."""

    def __init__(self, figure: Figure, span: Span, digits: int):
        self.digits = digits
        self.time = self._after(figure, LEFT, "$t=$")
        self.extremes = self._after(figure, 0.42 * figure.bbox.width, f"{span.label}: ")
        self.moving: list[Artist] = [self.time, self.extremes]

    def _after(self, figure: Figure, left: float, label: str) -> Text:
        """A text to be changed, behind a label that stays: formulas are slow to set."""
        width, height = figure.bbox.size
        top = 1.0 - 0.4 * TOP / height
        end = figure.text(left / width, top, label, va="baseline").get_window_extent().x1
        return figure.text((end + SPACE) / width, top, "", va="baseline")

    def show(self, moment: Moment) -> None:
        self.time.set_text(f"{moment.time:.{self.digits}f}")
        self.extremes.set_text(f"{moment.low:#.3g} to {moment.high:#.3g}")


class Curves:
    """The extremes against time, and where the moment is."""

    def __init__(self, axes: Axes, span: Span, history: pd.DataFrame):
        curves(axes, history, span.curves)
        axes.set_xlabel("time $t\\,T_*^{1/2}/L_x$")
        axes.set_ylabel("$n/n_c$")
        axes.tick_params(labelsize=8)
        self.line = axes.axvline(0.0, color="gray", linewidth=0.8)
        (self.dots,) = axes.plot([0.0, 0.0], [1.0, 1.0], "o", color="black", markersize=4)
        self.moving: list[Artist] = [self.line, self.dots]

    def show(self, moment: Moment) -> None:
        self.line.set_xdata([moment.time, moment.time])
        self.dots.set_data([moment.time, moment.time], [moment.low, moment.high])


def ends(density: np.ndarray, scale: str) -> tuple[float, float]:
    """Ends of the scale for a density: zero or, of a logarithmic one, its least value above zero; and its largest."""
    high = float(density.max())
    least = float(density.min(initial=high, where=density > 0.0))
    return (min(least, (1.0 - NARROWEST) * high) if scale == "log" else 0.0), high


def averages(field: np.ndarray, faces: np.ndarray, pixels: np.ndarray) -> np.ndarray:
    """Averages along axis 0 between the edges `pixels` of what is uniform in cells between `faces`."""
    widths = np.diff(faces)
    integral = np.concatenate([np.zeros_like(field[:1]), np.cumsum(field * widths[:, None], axis=0)])
    cell = np.clip(np.searchsorted(faces, pixels, side="right") - 1, 0, widths.size - 1)
    integral = integral[cell] + field[cell] * (pixels - faces[cell])[:, None]
    return np.diff(integral, axis=0) / np.diff(pixels)[:, None]
