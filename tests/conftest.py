"""What tests share."""

from __future__ import annotations

import json
import os
import platform
import signal
from importlib.metadata import version
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command line does, before numpy is there

import pytest

from hydro.cli import main
from hydro.movies.frames import frames
from hydro.output.checkpoint import read_checkpoint
from hydro.output.folder import RunFolder

signal.signal(signal.SIGINT, signal.default_int_handler)  # shells let what is begun in the background ignore it

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


MACHINE = {"wall_seconds", "cell_updates_per_second", "peak_memory_bytes", "compile_seconds"}  # of a summary


def outcome(folder: Path) -> dict[str, Any]:
    """All that a run leaves that must not depend on interruptions, by name, bit for bit."""
    saved = read_checkpoint(RunFolder(folder).saved()[-1])
    return {
        "books": repr([saved.time, saved.steps, saved.rejected, saved.dt, saved.dt_limit, saved.set_by, saved.ledger]),
        "snapshots": repr(saved.snapshots),
        "conserved": saved.conserved.tobytes(),
        "x": saved.mesh.x_faces.tobytes(),
        "y": saved.mesh.y_faces.tobytes(),
        **{name: values.tobytes() for name, values in saved.memory.items()},
        "history": (folder / "history.csv").read_bytes(),
        **{key: value for key, value in summary_of(folder).items() if key not in MACHINE},
        **{path.name: path.read_bytes() for path in frames(folder / "frames")},
    }


def differences(folder: Path, expected: dict[str, Any]) -> list[str]:
    """Names of all that is not as expected in a folder."""
    found = outcome(folder)
    return [name for name in expected | found if found.get(name) != expected.get(name)]


def restart(folder: Path, *overrides: str) -> int:
    """The exit code of a restart."""
    return main(["restart", str(folder), *overrides, "--quiet"])


def pytest_terminal_summary(terminalreporter):
    """Name the versions that a test run was made with."""
    libraries = ", ".join(f"{name} {version(name)}" for name in ("numba", "numpy", "scipy", "h5py", "pydantic"))
    terminalreporter.write_line(f"with Python {platform.python_version()}, {libraries}")


def go_on_alike(first: Any, second: Any, state: Any) -> bool:
    """Whether an integrator that is told what another remembers goes on as that does, bit for bit, for five steps."""
    copy = state.copy()
    second.remember(first.memory())
    for integrator, each in ((first, state), (second, copy)):
        for _ in range(5):
            integrator.step(each, integrator.largest_step(each))
    return bool((state.conserved == copy.conserved).all())
