"""The folder of a run: what lies where."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path
from typing import Any

from hydro.errors import DeckError
from hydro.runs.files import write_text

OWN_FILES = ("deck.toml", "summary.json", "history.csv")
OWN_FOLDERS = ("checkpoints", "pictures")


class RunFolder:
    """Paths in a run's folder.

    deck.toml (resolved), summary.json, history.csv, checkpoints/, pictures/.
    """

    def __init__(self, path: Path):
        self.path = path
        self.deck = path / "deck.toml"
        self.summary = path / "summary.json"
        self.history = path / "history.csv"
        self.checkpoints = path / "checkpoints"
        self.pictures = path / "pictures"

    def prepare(self, deck: str, overwrite: bool) -> None:
        """Make the folder and write the resolved deck into it.

        DeckError when it cannot be made, or holds another run and is not to be overwritten.
        """
        if self.deck.exists() and not overwrite:
            raise DeckError(f"{self.path} holds a run already; --overwrite replaces it", "output folder")
        try:
            self._clear()
            for folder in (self.path, self.checkpoints, self.pictures):
                folder.mkdir(parents=True, exist_ok=True)
            write_text(self.deck, deck)
        except OSError as error:
            raise DeckError(f"{self.path} cannot be written: {error.strerror}", "output folder") from error

    def _clear(self) -> None:
        """Remove what an earlier run left, and nothing else."""
        for name in OWN_FOLDERS:
            shutil.rmtree(self.path / name, ignore_errors=True)
        for name in OWN_FILES:
            (self.path / name).unlink(missing_ok=True)

    def write_summary(self, summary: dict[str, Any]) -> None:
        """Write summary.json; numbers that JSON does not know become null."""
        write_text(self.summary, json.dumps(_plain(summary), indent=2, allow_nan=False) + "\n")


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
