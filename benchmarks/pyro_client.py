"""pyro2 in its own virtual environment, driven as a subprocess."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

REQUIREMENTS = ("pyro-hydro==4.5.1", "scipy")  # pyro's kernels need scipy, its package does not say so
WORKER = Path(__file__).with_name("pyro_worker.py")
ONE_CORE = {name: "1" for name in ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}


class PyroUnavailableError(Exception):
    """pyro2 cannot be installed or does not run; says why."""


def default_environment() -> Path:
    """Where pyro2 is installed unless the user names a place. Not in hydro's own cache, which is pruned."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "hydro-benchmarks" / "pyro"


def installed(environment: Path) -> Path:
    """The Python of an environment with pyro2, installed on first use; PyroUnavailableError when that fails."""
    python = environment / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    complete = environment / "complete"
    if not complete.exists() or complete.read_text() != repr(REQUIREMENTS):
        print(f"installing {', '.join(REQUIREMENTS)} into {environment}", file=sys.stderr)
        _command(sys.executable, "-m", "venv", "--clear", str(environment))
        _command(str(python), "-m", "pip", "install", "--quiet", *REQUIREMENTS)
        complete.write_text(repr(REQUIREMENTS))
    return python


def _command(*words: str) -> None:
    try:
        done = subprocess.run(words, capture_output=True, text=True, check=False)
    except OSError as error:
        raise PyroUnavailableError(f"cannot run {words[0]}: {error}") from error
    if done.returncode:
        last = "\n".join(done.stderr.strip().splitlines()[-5:])
        raise PyroUnavailableError(f"`{' '.join(words)}` failed:\n{last}")


class Pyro:
    """A running pyro2 worker on one core; a context manager. `versions` is known after the first setup."""

    def __init__(self, environment: Path):
        self._python = installed(environment)
        self.versions: dict[str, str] = {}

    def __enter__(self) -> Pyro:
        self._folder = tempfile.TemporaryDirectory(prefix="hydro-pyro-")  # pyro writes inputs.auto where it runs
        self._log = Path(self._folder.name) / "log"
        self._process = subprocess.Popen(
            [str(self._python), str(WORKER)], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=self._log.open("w"), text=True, cwd=self._folder.name, env=_environment(),
        )  # fmt: skip
        return self

    def __exit__(self, kind: type | None, value: BaseException | None, trace: TracebackType | None) -> None:
        assert self._process.stdin and self._process.stdout
        self._process.stdin.close()
        self._process.wait()
        self._process.stdout.close()
        self._folder.cleanup()

    def setup(self, conserved: np.ndarray, gamma: float, parameters: dict[str, Any]) -> None:
        """Start from `conserved`, (4, n, n): density, momenta, energy, on the periodic unit square; compiled."""
        file = Path(self._folder.name) / "state.npy"
        np.save(file, conserved)
        self.versions = self._ask("setup", state=str(file), gamma=gamma, parameters=parameters)["versions"]

    def steps(self, count: int) -> float:
        """Seconds for `count` full steps."""
        return self._ask("steps", count=count)["seconds"]

    def until(self, time: float) -> float:
        """Seconds for all steps up to the given time."""
        return self._ask("until", time=time)["seconds"]

    def density(self) -> np.ndarray:
        """The density, (n, n)."""
        file = Path(self._folder.name) / "density.npy"
        self._ask("density", file=str(file))
        return np.load(file)

    def _ask(self, what: str, **arguments: Any) -> dict[str, Any]:
        assert self._process.stdin and self._process.stdout
        try:
            print(json.dumps({"do": what, **arguments}), file=self._process.stdin, flush=True)
            answer = self._process.stdout.readline()
        except BrokenPipeError:
            answer = ""
        if not answer:
            raise PyroUnavailableError("the pyro worker ended:\n" + "\n".join(self._log.read_text().splitlines()[-5:]))
        return json.loads(answer)


def _environment() -> dict[str, str]:
    """One core, no windows, and none of our Python path or kernel cache."""
    ours = ("PYTHONPATH", "PYTHONHOME", "NUMBA_CACHE_DIR")
    return {name: value for name, value in os.environ.items() if name not in ours} | ONE_CORE | {"MPLBACKEND": "Agg"}
