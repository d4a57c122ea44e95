"""A tidy table, one row for each run of a study, as CSV and, where pyarrow is installed, as Parquet."""

from __future__ import annotations

import json
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from hydro.output.files import replacing

Row = dict[str, Any]


def write_table(path: Path, rows: Sequence[Row]) -> None:
    """Write rows, all with the same columns, to the CSV file `path`; with pyarrow, to a Parquet file beside it too.

    Lists and sections become JSON text; so does all of a column with text in it.
    """
    import pandas as pd  # slow to import

    columns = {name: plain([row[name] for row in rows]) for name in (rows[0] if rows else ())}
    table = pd.DataFrame(columns, dtype=object)  # whole numbers stay whole beside those that are missing
    with replacing(path) as temporary:
        table.to_csv(temporary, index=False)
    if find_spec("pyarrow"):
        with replacing(path.with_suffix(".parquet")) as temporary:
            table.to_parquet(temporary, index=False)


def plain(values: list[Any]) -> list[Any]:
    """A column of numbers, or else of text, with None where there is nothing."""
    if all(value is None or isinstance(value, bool | int | float) for value in values):
        return values
    return [value if value is None or isinstance(value, str) else json.dumps(value) for value in values]
