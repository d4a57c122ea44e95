"""What tests share."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hydro.cli import main

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
