"""What tests share."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from hydro.cli import main
from hydro.runs.checkpoint import read_checkpoint
from hydro.runs.folder import RunFolder

PROBLEMS = Path(__file__).parent.parent / "problems"


@pytest.fixture
def run_deck(tmp_path):
    """Runs a deck of the repository by the command line into a temporary folder: (folder, exit code)."""

    def run(name: str, *overrides: str, folder: str = "run", options: tuple[str, ...] = ("--quiet",)):
        target = tmp_path / folder
        code = main([str(PROBLEMS / f"{name}.toml"), *overrides, "--output", str(target), *options])
        return target, code

    return run


def summary_of(folder: Path) -> dict:
    """The summary of a run."""
    return json.loads((folder / "summary.json").read_text())


TIMINGS = {"wall_seconds", "cell_updates_per_second", "peak_memory_bytes", "compile_seconds"}


def left_by(folder: Path) -> dict[str, Any]:
    """All that a run leaves that must not depend on interruptions, bit for bit."""
    saved = read_checkpoint(RunFolder(folder).saved()[-1])
    arrays = {"conserved": saved.conserved, "x": saved.mesh.x_faces, "y": saved.mesh.y_faces, **saved.memory}
    books = (saved.time, saved.steps, saved.rejected, saved.dt, saved.dt_limit, saved.set_by, saved.ledger)
    return {
        "arrays": {name: values.tobytes() for name, values in arrays.items()},
        "books": books,
        "snapshots": saved.snapshots,
        "history": (folder / "history.csv").read_bytes(),
        "summary": {key: value for key, value in summary_of(folder).items() if key not in TIMINGS},
    }
