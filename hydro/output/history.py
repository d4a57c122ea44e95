"""Reading the history of a run, a CSV file, also while the run goes on, and after a kill."""

from __future__ import annotations

from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd


def read_rows(path: Path) -> pd.DataFrame:
    """The rows of a history file, up to the first that is damaged or not finished; empty where there is no file."""
    import pandas as pd  # slow to import

    header, rows = whole_lines(path)
    columns = header.split(",") if header else []
    return pd.DataFrame([row.split(",") for row in rows], columns=columns, dtype=str).astype(float)


def whole_lines(path: Path) -> tuple[str, list[str]]:
    """Header and rows of a history file, up to the first row that is damaged; nothing if there is no file."""
    text = path.read_text(encoding="utf-8", errors="replace") if path.exists() else ""
    header, *rows = text.split("\n")[:-1] or [""]
    return header, list(takewhile(lambda row: is_whole(row, header.count(",")), rows))


def is_whole(row: str, commas: int) -> bool:
    """Whether a row has a number in every column."""
    try:
        return len([float(value) for value in row.split(",")]) == commas + 1
    except ValueError:
        return False


def time_of(row: str) -> float:
    """The first column."""
    return float(row.partition(",")[0])
