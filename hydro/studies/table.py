"""A tidy table, one row for each run of a study, as CSV and as Parquet."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hydro.output.files import replacing

Row = dict[str, Any]


def write_table(path: Path, rows: Sequence[Row]) -> None:
    """Write rows, all with the same columns, to the CSV file `path` and to a Parquet file beside it.

    Lists and sections become JSON text; so does all of a column with text in it.
    """
    import pyarrow  # slow to import
    from pyarrow import parquet

    columns = {name: plain([row[name] for row in rows]) for name in (rows[0] if rows else ())}
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))
    with replacing(path.with_suffix(".parquet")) as temporary:
        parquet.write_table(pyarrow.table(columns), temporary)


def plain(values: list[Any]) -> list[Any]:
    """A column of numbers, or else of text, with None where there is nothing."""
    if all(value is None or isinstance(value, bool | int | float) for value in values):
        return values
    return [value if value is None or isinstance(value, str) else json.dumps(value) for value in values]
