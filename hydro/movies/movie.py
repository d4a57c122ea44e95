"""Movies of evolutions: from the frames that a run has kept, or else from its checkpoints, also while it goes on.

Simulated time passes evenly: each moment is shown for as long as it was the latest that was kept.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from itertools import chain, pairwise, repeat
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hydro.deck.evolution import RunDeck
from hydro.errors import CheckpointError, DeckError
from hydro.mesh import Mesh
from hydro.movies.frames import frame_time, frames, read_frame
from hydro.movies.moving import Board, MovingPicture, ends
from hydro.movies.video import gif, mp4
from hydro.observables import observables_of
from hydro.output.checkpoint import leave_out, read_field, readable_times
from hydro.output.dataset import read_history
from hydro.output.folder import RunFolder
from hydro.progress import counted
from hydro.setup import mesh_of

SHORTEST = 8.0  # seconds that a movie lasts at least
ROUND_OFF = 1e-9  # in times, relative to the interval between pictures
PAUSE = 1.0  # seconds that the last moment stays


class Source(NamedTuple):
    """Densities that a run has kept: the times of their files, in order, and how to read one."""

    times: dict[Path, float]
    read: Callable[[Path], np.ndarray]


def make_movie(deck: Any, folder: RunFolder, quiet: bool = False) -> list[Path]:
    """Write movie.mp4 and, unless the deck says no, movie.gif into the folder of a run; returns their paths.

    DeckError if the folder holds neither an evolution nor grains; CheckpointError if there is nothing to show;
    RunFailed if the encoder fails. What cannot be read is named on stderr and left out.
    """
    if not isinstance(deck, RunDeck):
        raise DeckError(
            f"{folder.path} holds a run of kind {deck.kind!r}; movies are made of evolutions and grains", "run folder"
        )
    source, mesh, look = source_in(folder), mesh_of(deck), deck.movie
    times = list(source.times.values())
    interval = interval_of(times, deck.movie_interval, look.frames_per_second)
    counts = dict(zip(source.times, repeats(times, interval, look.frames_per_second), strict=True))
    shown = counted([path for path in source.times if counts[path]], f"{folder.path.name}, movie", quiet)
    limits = common_ends(readable(source.times, source, mesh), look.scale) if look.limits == "run" else None
    span = observables_of(deck).span
    history = read_history(folder.path).reset_index() if look.traces and span.curves else None
    picture = MovingPicture(mesh, span, look, limits, history, digits=max(0, math.ceil(-math.log10(interval))))

    def pictures() -> Iterator[np.ndarray]:
        for path, density in readable(shown, source, mesh):
            yield from repeat(picture.at(source.times[path], density), counts[path])

    mp4(folder.movie, pictures(), look.frames_per_second)
    if not look.gif:
        return [folder.movie]
    gif(folder.gif, folder.movie, look.frames_per_second)
    return [folder.movie, folder.gif]


def side_by_side(path: Path, runs: Sequence[tuple[str, RunFolder, Mesh]], deck: RunDeck, quiet: bool = False) -> None:
    """Write the densities of runs, by name, folder and mesh, side by side as `path`; a GIF too, if the deck wants one.

    Each is shown at the latest moment that it has kept; `movie.limits` = "run" gives all one scale. Errors as for
    `make_movie`.
    """
    look, span = deck.movie, observables_of(deck).span
    sources = [source_in(folder) for _, folder, _ in runs]
    times = sorted(time for source in sources for time in source.times.values())
    interval = interval_of(times, deck.movie_interval, look.frames_per_second)
    digits = max(0, math.ceil(-math.log10(interval)))
    shown = [(source, mesh) for (_, _, mesh), source in zip(runs, sources, strict=True)]
    every = chain.from_iterable(readable(source.times, source, mesh) for source, mesh in shown)
    limits = common_ends(every, look.scale) if look.limits == "run" else None
    sides = [Side(source, mesh, MovingPicture(mesh, span, look, limits, None, digits)) for source, mesh in shown]
    board = Board([name for name, _, _ in runs], [side.picture.size for side in sides])
    moving = math.ceil((times[-1] - times[0]) / interval) + 1
    pause = [times[-1]] * round(PAUSE * look.frames_per_second)
    moments = [*(times[0] + interval * np.arange(moving)), *pause]

    def pictures() -> Iterator[np.ndarray]:
        for now in counted(moments, path.name, quiet):
            for number, side in enumerate(sides):
                if (frame := side.at(now + ROUND_OFF * interval)) is not None:
                    board.put(number, frame)
            yield board.pixels

    mp4(path, pictures(), look.frames_per_second)
    if look.gif:
        gif(path.with_suffix(".gif"), path, look.frames_per_second)


class Side:
    """One of the runs in a movie of several: its moments come one after the other, each when it is due."""

    def __init__(self, source: Source, mesh: Mesh, picture: MovingPicture):
        self.source, self.picture = source, picture
        self._moments = readable(source.times, source, mesh)
        self._coming: tuple[Path, np.ndarray] | None = next(self._moments)
        self._due = -math.inf

    def at(self, now: float) -> np.ndarray | None:
        """The picture of the latest moment up to `now`, the first if there is none; None where it has been given."""
        latest = None
        while self._coming is not None and self._due <= now:
            latest, self._coming = self._coming, next(self._moments, None)
            self._due = math.inf if self._coming is None else self.source.times[self._coming[0]]
        return None if latest is None else self.picture.at(self.source.times[latest[0]], latest[1])


def source_in(folder: RunFolder) -> Source:
    """The frames in a folder or, where there are none, its checkpoints; CheckpointError if there are none either."""
    times = {path: frame_time(path) for path in frames(folder.frames)}
    if times:
        return Source(times, read_frame)
    times = readable_times(folder.checkpoints)
    if not times:
        raise CheckpointError(f"{folder.path} has neither frames nor checkpoints yet")
    return Source(times, partial(read_field, name="density"))


def readable(paths: Iterable[Path], source: Source, mesh: Mesh) -> Iterator[tuple[Path, np.ndarray]]:
    """The files among `paths` that can be read, each with its density of shape (nx, ny); CheckpointError if none."""
    found = False
    for path in paths:
        try:
            density = source.read(path)
        except CheckpointError as error:
            leave_out(str(error))
            continue
        if density.shape != mesh.cells:
            leave_out(f"{path}: a density of shape {density.shape} on a mesh of {mesh.cells} cells")
            continue
        found = True
        yield path, density
    if not found:
        raise CheckpointError("there is nothing to show")


def interval_of(times: Sequence[float], every: float, rate: int) -> float:
    """Scaled time between two pictures of a movie of `rate` a second, of moments kept about every `every`.

    As many pictures as moments, but enough for the shortest movie.
    """
    span = times[-1] - times[0]
    return min(max(every, span / len(times)), span / (SHORTEST * rate)) or every


def repeats(times: Sequence[float], interval: float, rate: int) -> list[int]:
    """How many pictures, one for each interval, show each moment as the latest; the last one stays for a while."""
    ticks = [math.ceil((time - times[0]) / interval - ROUND_OFF) for time in times]
    return [*(after - before for before, after in pairwise(ticks)), round(PAUSE * rate)]


def common_ends(densities: Iterable[tuple[Path, np.ndarray]], scale: str) -> tuple[float, float]:
    """Ends of a scale for all densities."""
    lows, highs = zip(*(ends(density, scale) for _, density in densities), strict=True)
    return min(lows), max(highs)
