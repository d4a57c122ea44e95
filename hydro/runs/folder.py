"""The folder of a run: what lies where."""

from __future__ import annotations

import json
import math
import os
import shutil
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from hydro.deck import Deck, load
from hydro.errors import DeckError
from hydro.runs.files import write_text

OWN_FILES = (
    "deck.toml", "summary.json", "history.csv", "points.csv", "table.csv", "table.parquet", "checkpoints.xdmf",
    "movie.mp4", "movie.gif", "report.html",
)  # fmt: skip
OWN_FOLDERS = ("checkpoints", "frames", "members", "pictures")


class RunFolder:
    """Paths in a run's folder.

    deck.toml (resolved), summary.json, checkpoints/, pictures/; of an evolution history.csv, checkpoints.xdmf and,
    where a movie is made, frames/, movie.mp4 and movie.gif; points.csv of a branch; of a study members/ (folders of
    runs), table.csv and table.parquet.
    """

    def __init__(self, path: Path):
        self.path = path
        self.deck = path / "deck.toml"
        self.summary = path / "summary.json"
        self.history = path / "history.csv"
        self.points = path / "points.csv"
        self.checkpoints = path / "checkpoints"
        self.series = path / "checkpoints.xdmf"
        self.frames = path / "frames"
        self.movie = path / "movie.mp4"
        self.gif = path / "movie.gif"
        self.pictures = path / "pictures"
        self.comparison = path / "compare"
        self.report = path / "report.html"
        self.members = path / "members"
        self.table = path / "table.csv"
        self.anew = False  # whether what is there is to be replaced, and nothing of it used

    def load_deck(self, overrides: Iterable[str] = ()) -> Deck:
        """The deck of the run that the folder holds, changed by overrides; DeckError if it holds none."""
        if not self.deck.is_file():
            raise DeckError(f"{self.path} is no folder of a run: it has no {self.deck.name}", "run folder")
        return load(self.deck, overrides)

    def holds(self, deck: str) -> bool:
        """Whether the run in this folder, finished or not, is that of a resolved deck."""
        return self.deck.exists() and self.deck.read_text(encoding="utf-8") == deck

    def member(self, number: int) -> RunFolder:
        """The folder of a run that a study is made of."""
        return RunFolder(self.members / f"{number:04d}")

    def check(self, overwrite: bool, resumable: str | None = None) -> None:
        """DeckError if the folder holds a run that is not to be replaced, or files that no run made, or cannot be made.

        So hours of work do not end there. resumable: a deck whose run may go on where it was left.
        """
        self.anew = overwrite
        if self.deck.exists():
            if not overwrite and not (resumable and self.holds(resumable)):
                raise DeckError(f"{self.path} holds a run already; --overwrite replaces it", "output folder")
        elif taken := [name for name in (*OWN_FILES, *OWN_FOLDERS) if (self.path / name).exists()]:
            raise DeckError(f"{self.path} is no folder of a run, but has {', '.join(taken)}", "output folder")
        place = next(place for place in (self.path, *self.path.absolute().parents) if place.exists())
        if not place.is_dir() or not os.access(place, os.W_OK | os.X_OK):
            raise DeckError(f"{self.path} cannot be written: {place} is no folder to write into", "output folder")

    def prepare(self, deck: str) -> None:
        """Make the folder, without the files of the run it may hold, and write the resolved deck into it.

        DeckError when that cannot be done.
        """
        try:
            self._clear()
            for folder in (self.path, self.checkpoints, self.pictures):
                folder.mkdir(parents=True, exist_ok=True)
            write_text(self.deck, deck)
        except OSError as error:
            raise DeckError(f"{self.path} cannot be written: {error.strerror}", "output folder") from error

    def resume(self, deck: str) -> None:
        """As `prepare`; but where this very study was begun, its members are kept."""
        if self.anew or not self.holds(deck):
            shutil.rmtree(self.members, ignore_errors=True)
        self.prepare(deck)
        self.members.mkdir(exist_ok=True)

    def _clear(self) -> None:
        """Remove what an earlier run left, but for the members of a study, and nothing else."""
        made = [self.path / name for name in OWN_FILES]
        made += [*self.checkpoints.glob("*.h5"), *self.frames.glob("*.h5")]
        made += [*self.pictures.glob("*.png"), *self.pictures.glob("*.pdf")]
        made += [*self.comparison.glob("*.png"), *self.comparison.glob("*.json")]
        for path in made:
            path.unlink(missing_ok=True)

    def read_summary(self) -> dict[str, Any]:
        """What summary.json says."""
        return json.loads(self.summary.read_text(encoding="utf-8"))

    def write_summary(self, summary: dict[str, Any]) -> None:
        """Write summary.json; numbers that JSON does not know become null."""
        write_json(self.summary, summary)


def write_json(path: Path, values: dict[str, Any]) -> None:
    """Write `values` to `path`, whole or not at all; numbers that JSON does not know become null."""
    write_text(path, json.dumps(_plain(values), indent=2, allow_nan=False) + "\n")


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
