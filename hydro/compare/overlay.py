"""Runs beside each other: grains and hydrodynamics, seeds, meshes, integrators, neighbouring parameters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from hydro.deck import EvolutionDeck, GrainsDeck
from hydro.errors import DeckError
from hydro.mesh import Mesh
from hydro.observables import Observables, observables_in, observables_of
from hydro.observables.sets import error_of
from hydro.output.checkpoint import averaged, read_or_skip, readable_times
from hydro.output.folder import RunFolder, write_json
from hydro.output.history import read_rows
from hydro.setup import mesh_of

if TYPE_CHECKING:
    import pandas as pd


class Overlaid(NamedTuple):
    """A run among others: its name and folder, its deck, the rows of its history, its last density, (nx, ny)."""

    name: str
    folder: RunFolder
    deck: Any
    history: pd.DataFrame
    time: float
    density: np.ndarray
    mesh: Mesh

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
        if saved is None or history.empty:
            raise DeckError(f"{path} has no checkpoint or no history yet", "RUNDIR")
        return cls(path.resolve().name, folder, deck, history, saved.time, averaged(saved)[0], mesh_of(deck))

    def last(self, columns: Sequence[str]) -> dict[str, float | None]:
        """The last row of the history: time, columns, and their standard errors as far as they are known.

        DeckError if it has no such columns.
        """
        row = self.history.iloc[-1]
        if missing := [name for name in ("time", *columns) if name not in row]:
            raise DeckError(f"{self.folder.history} has no column {missing[0]!r}: an older version wrote it", "RUNDIR")
        errors = {error_of(name): float(row[error_of(name)]) for name in columns if error_of(name) in row}
        known = {name: error if math.isfinite(error) else None for name, error in errors.items()}
        return {name: float(row[name]) for name in ("time", *columns)} | known


def overlay(paths: Sequence[Path], output: Path, movie: bool = False, quiet: bool = False) -> dict[str, Any]:
    """Draw the histories of runs over each other, and their last densities side by side, into the folder `output`.

    With `movie` their densities move there side by side, too, in the look that the first deck asks for.

    Returns what overlay.json there holds: "runs", a row for each. DeckError for folders that have no such runs, or if
    `output` is the folder of one or cannot be made.
    """
    if RunFolder(output).deck.exists():
        raise DeckError(f"{output} is the folder of a run; choose another with --output", "output folder")
    runs = named_apart([Overlaid.of(path) for path in paths], paths)
    seen = observables_of(runs[0].deck)
    columns = columns_of(seen)
    result = {"observables": seen.name, "runs": [{"run": run.name, **run.last(columns)} for run in runs]}
    from hydro.pictures.density import Map, density_panels  # matplotlib is slow to import
    from hydro.pictures.overlay import overlaid_histories
    from hydro.pictures.style import literally

    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DeckError(f"{output} cannot be written: {error.strerror}", "output folder") from error
    overlaid_histories(output / "history.png", seen.overlaid, [(run.name, run.history) for run in runs])
    titles = [f"{literally(run.name)}, $t={run.time:g}$" for run in runs]
    notes = [seen.span.note(run.density, run.mesh) for run in runs]
    shown = zip(runs, titles, notes, strict=True)
    density_panels(output / "states.png", [Map(run.density, run.mesh, title, note) for run, title, note in shown])
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


def columns_of(seen: Observables) -> list[str]:
    """What is told of each run at its end: the columns of the history that are drawn."""
    return [curve.column for panel in seen.overlaid for curve in panel.curves]


def closing(result: dict[str, Any]) -> list[str]:
    """The last rows of the histories, as a table."""
    rows, seen = result["runs"], observables_in(result)
    columns = columns_of(seen)
    width = max(len(row["run"]) for row in rows) + 2
    header = f"{'':<{width}}{'t':>10}" + "".join(f"{seen.label(name):>22}" for name in columns)
    lines = ["".join(entry(row[name], row.get(error_of(name))) for name in columns) for row in rows]
    return [header, *(f"{row['run']:<{width}}{row['time']:>10g}{line}" for row, line in zip(rows, lines, strict=True))]


def entry(value: float, error: float | None) -> str:
    """A number with its error, where that is known."""
    return f"{f'{value:.4g}' if error is None else f'{value:.4g} ± {error:.1g}':>22}"
