"""The folder of a run: what lies where."""

from __future__ import annotations

import contextlib
import json
import math
import os
import shutil
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from hydro.deck import Deck, dumps, load
from hydro.errors import DeckError
from hydro.output.files import partial, write_text
from hydro.output.lock import locked

OWN_FILES = (
    "deck.toml", "summary.json", "history.csv", "points.csv", "table.csv", "table.parquet", "checkpoints.xdmf",
    "movie.mp4", "movie.gif", "report.html",
)  # fmt: skip
OWN_FOLDERS = ("checkpoints", "frames", "members", "pictures", "compare")
DAMAGED = ".damaged"  # follows the names of checkpoints that could not be read


class RunFolder:
    """Paths in a run's folder.

    deck.toml (resolved), summary.json, checkpoints/, pictures/; of an evolution or grains history.csv,
    checkpoints.xdmf and, where a movie is made, frames/, movie.mp4 and movie.gif; points.csv of a branch; of a study
    members/ (folders of runs), table.csv and table.parquet.
    .lock is held while a process works here.
    """

    def __init__(self, path: Path):
        self.path = path
        self.lock = path / ".lock"
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

    def holds(self, deck: Deck) -> bool:
        """Whether the run in this folder, finished or not, is that of a deck."""
        try:
            return self.deck.is_file() and load(self.deck) == deck
        except DeckError:  # of another version of this program
            return False

    def member(self, number: int) -> RunFolder:
        """The folder of a run that a study is made of."""
        return RunFolder(self.members / f"{number:04d}")

    @contextlib.contextmanager
    def held(self) -> Iterator[None]:
        """Make the folder and keep other processes from working in it.

        DeckError if another process works there, or the folder cannot be made or written: hours of work shall not end
        there.
        """
        place = next(place for place in (self.path, *self.path.absolute().parents) if place.exists())
        if not place.is_dir() or not os.access(place, os.W_OK | os.X_OK):
            raise DeckError(f"{self.path} cannot be written: {place} is no folder to write into", "output folder")
        made = not self.path.exists()
        with contextlib.ExitStack() as stack:
            try:
                self.path.mkdir(parents=True, exist_ok=True)
                stack.enter_context(locked(self.lock))
            except OSError as error:
                raise DeckError(f"{self.path} cannot be written: {error.strerror}", "output folder") from error
            try:
                yield
            finally:
                self._leave(made)

    def _leave(self, made: bool) -> None:
        """Remove the lock's file where no run has begun, and the folder if it was made for one."""
        if not self.deck.exists():
            self.lock.unlink(missing_ok=True)
            if made and not any(self.path.iterdir()):
                self.path.rmdir()

    def check(self, overwrite: bool, resumable: Deck | None = None) -> None:
        """DeckError if the folder holds a run that is not to be replaced, or files that no run made.

        resumable: a deck whose run may go on where it was left.
        """
        self.anew = overwrite
        if self.deck.exists():
            if not overwrite and (resumable is None or not self.holds(resumable)):
                raise DeckError(f"{self.path} holds a run already; --overwrite replaces it", "output folder")
        elif taken := [name for name in (*OWN_FILES, *OWN_FOLDERS) if (self.path / name).exists()]:
            raise DeckError(f"{self.path} is no folder of a run, but has {', '.join(taken)}", "output folder")

    def prepare(self, deck: str, keep: bool = False) -> None:
        """Make the folder, without the files of the run it may hold, and write the resolved deck into it.

        With `keep` those files stay, but for the summary, which is no longer true. DeckError when that cannot be done.
        """
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            for path in [self.summary] if keep else self._made():
                path.unlink(missing_ok=True)
            write_text(self.deck, deck)  # before anything else is there: what lies beside a deck is known to be a run's
            for folder in (self.path, self.checkpoints, self.pictures):
                folder.mkdir(exist_ok=True)
            for folder in (self.path, self.checkpoints, self.pictures, self.frames):
                for path in partial(folder):
                    path.unlink()
        except OSError as error:
            raise DeckError(f"{self.path} cannot be written: {error.strerror}", "output folder") from error

    def resume(self, deck: Deck) -> None:
        """As `prepare`; but where this very study was begun, its members are kept."""
        if self.anew or not self.holds(deck):
            for begun in self.members.glob("[0-9]*/deck.toml"):
                shutil.rmtree(begun.parent)
        self.prepare(dumps(deck))
        self.members.mkdir(exist_ok=True)

    def _made(self) -> list[Path]:
        """All that a run leaves, but for its deck."""
        made = [self.path / name for name in OWN_FILES if name != self.deck.name]
        made += [*self.checkpoints.glob(f"*.h5{DAMAGED}"), *self.checkpoints.glob("*.h5")]
        made += [*self.frames.glob("*.h5"), *self.pictures.glob("*.png"), *self.pictures.glob("*.pdf")]
        return [*made, *self.comparison.glob("*.png"), *self.comparison.glob("*.json")]

    def saved(self) -> list[Path]:
        """The checkpoints, by name; those of an evolution or grains are then in the order of time."""
        return sorted(self.checkpoints.glob("[!.]*.h5"))

    def read_summary(self) -> dict[str, Any]:
        """What summary.json says; nothing where there is none, or none that can be read."""
        try:
            summary = json.loads(self.summary.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return {}
        return summary if isinstance(summary, dict) else {}

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
