"""Runs beside each other: grains and hydrodynamics, seeds, meshes, integrators, neighbouring parameters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hydro.deck import EvolutionDeck, GrainsDeck
from hydro.driver.history import read_rows
from hydro.errors import DeckError
from hydro.observables.clustering import wall_extremes
from hydro.output.checkpoint import averaged, read_or_skip, readable_times
from hydro.output.folder import RunFolder, write_json
from hydro.setup import mesh_of

# What is told of each run at its end, by column of its history.
COLUMNS = {
    "wall_max": "largest n(0, y)",
    "wall_min": "smallest n(0, y)",
    "gas_density": "n at x = 1",
    "centre_x": "mean x",
}


class Overlaid(NamedTuple):
    """A run among others: its name and folder, the rows of its history, and the last density it has saved, (nx, ny)."""

    name: str
    folder: RunFolder
    deck: Any
    history: np.ndarray
    time: float
    density: np.ndarray
    mesh: Any

    @classmethod
    def of(cls, path: Path) -> Overlaid:
        """DeckError if the folder holds no evolution, nor grains, or nothing of it yet."""
        folder = RunFolder(path)
        deck = folder.load_deck()
        if not isinstance(deck, EvolutionDeck | GrainsDeck):
            problem = f"{path} holds a run of kind {deck.kind!r}; only evolutions and grains can be overlaid"
            raise DeckError(problem, "RUNDIR")
        newest = reversed(readable_times(folder.checkpoints))
        saved = next(filter(None, map(read_or_skip, newest)), None)
        history = read_rows(folder.history)
        if saved is None or not history.size:
            raise DeckError(f"{path} has no checkpoint or no history yet", "RUNDIR")
        missing = [name for name in ("time", *COLUMNS) if name not in (history.dtype.names or ())]
        if missing:
            raise DeckError(f"{folder.history} has no column {missing[0]!r}: an older version wrote it", "RUNDIR")
        return cls(path.resolve().name, folder, deck, history, saved.time, averaged(saved)[0], mesh_of(deck))

    @property
    def last(self) -> dict[str, float | None]:
        """The last row of the history: time, what COLUMNS names, and the standard errors that are known."""
        row, names = self.history[-1], self.history.dtype.names or ()
        values = {name: float(row[name]) for name in ("time", *COLUMNS)}
        errors = {f"{name}_error": float(row[f"{name}_error"]) for name in COLUMNS if f"{name}_error" in names}
        return values | {name: error if math.isfinite(error) else None for name, error in errors.items()}

    @property
    def extremes(self) -> tuple[float, float]:
        """Smallest and largest density on the wall x = 0 at the last checkpoint."""
        return wall_extremes(self.density, self.mesh)


def overlay(paths: Sequence[Path], output: Path, movie: bool = False, quiet: bool = False) -> dict[str, Any]:
    """Draw the histories of runs over each other, and their last densities side by side, into the folder `output`.

    With `movie` their densities move there side by side, too, in the look that the first deck asks for.

    Returns what overlay.json there holds: "runs", a row for each. DeckError for folders that have no such runs, or if
    `output` is the folder of one or cannot be made.
    """
    if RunFolder(output).deck.exists():
        raise DeckError(f"{output} is the folder of a run; choose another with --output", "output folder")
    runs = named_apart([Overlaid.of(path) for path in paths], paths)
    result = {"runs": [{"run": run.name, **run.last} for run in runs]}
    from hydro.pictures.overlay import last_densities, overlaid_histories  # matplotlib is slow to import

    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DeckError(f"{output} cannot be written: {error.strerror}", "output folder") from error
    overlaid_histories(output / "history.png", runs)
    last_densities(output / "states.png", runs)
    write_json(output / "overlay.json", result)
    if movie:
        from hydro.movies.movie import side_by_side

        side_by_side(output / "overlay.mp4", [(run.name, run.folder, run.mesh) for run in runs], runs[0].deck, quiet)
    return result


def named_apart(runs: list[Overlaid], paths: Sequence[Path]) -> list[Overlaid]:
    """The runs, those of one name called by their folders as they were given."""
    names = [run.name for run in runs]
    return [
        run._replace(name=str(path)) if names.count(run.name) > 1 else run
        for run, path in zip(runs, paths, strict=True)
    ]


def closing(result: dict[str, Any]) -> list[str]:
    """The last rows of the histories, as a table."""
    rows = result["runs"]
    width = max(len(row["run"]) for row in rows) + 2
    header = f"{'':<{width}}{'t':>10}" + "".join(f"{title:>22}" for title in COLUMNS.values())
    return [header, *(f"{row['run']:<{width}}{row['time']:>10g}" + "".join(map(entry, *told(row))) for row in rows)]


def told(row: dict[str, Any]) -> tuple[list[float], list[float | None]]:
    """Numbers of a row, and their errors."""
    return [row[name] for name in COLUMNS], [row.get(f"{name}_error") for name in COLUMNS]


def entry(value: float, error: float | None) -> str:
    """A number with its error, where that is known."""
    return f"{f'{value:.4g}' if error is None else f'{value:.4g} ± {error:.1g}':>22}"
