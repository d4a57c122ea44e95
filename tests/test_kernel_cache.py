"""Machine code that is kept on disk is that of the sources as they are."""

from __future__ import annotations

import importlib
import os
import pkgutil
import subprocess
import sys
from pathlib import Path

import pytest
from numba.core.dispatcher import Dispatcher

import hydro
from hydro import kernel_cache

LAW = """
from typing import NamedTuple

from constants import FACTOR
from hydro.methods import compiled_methods


@compiled_methods
class Law(NamedTuple):
    offset: float

    def applied(self, x):
        return FACTOR * x + self.offset
"""

SCRIPT = """
import numpy as np

from hydro.jit import kernel
from law import Law


@kernel
def total(law, values):
    result = 0.0
    for value in values:
        result += law.applied(value)
    return result


print(total(Law(1.0), np.ones(4)), sum(total.stats.cache_hits.values()))
"""


def kernels() -> dict[str, list[Dispatcher]]:
    """The kernels that the modules of the package hold."""
    found: dict[str, list[Dispatcher]] = {}
    for info in pkgutil.walk_packages(hydro.__path__, "hydro."):
        if not info.name.endswith("__main__"):
            for value in vars(importlib.import_module(info.name)).values():
                if isinstance(value, Dispatcher) and value.py_func.__module__ == info.name:
                    found.setdefault(info.name, []).append(value)
    return found


def test_every_module_with_a_kernel_counts_itself_and_what_its_kernels_name():
    """Whatever module of the package a global of a kernel comes from is among the sources of that kernel."""
    held = kernels()
    assert len(held) > 8
    for module, dispatchers in held.items():
        sources = kernel_cache.sources_of({module})
        assert sources is None or Path(sys.modules[module].__file__) in sources
        for dispatcher in dispatchers:
            names = {name for code in codes(dispatcher.py_func.__code__) for name in code.co_names}
            for name in names & vars(sys.modules[module]).keys():
                home = home_of(vars(sys.modules[module])[name])
                assert home is None or sources is None or Path(sys.modules[home].__file__) in sources, (module, name)


def codes(code):
    return [code, *(part for part in code.co_consts if hasattr(part, "co_names"))]


def home_of(value) -> str | None:
    """The module of this package that a global names or comes from."""
    value = getattr(value, "py_func", value)
    name = getattr(value, "__module__", None) or getattr(value, "__name__", "")
    return name if isinstance(name, str) and name.startswith("hydro.") and name in sys.modules else None


@pytest.fixture
def tree(tmp_path):
    """A folder with a law, a constant that it imports, and a script whose kernel takes the law."""
    (tmp_path / "law.py").write_text(LAW)
    (tmp_path / "constants.py").write_text("FACTOR = 2.0\n")
    (tmp_path / "script.py").write_text(SCRIPT)
    for path in tmp_path.iterdir():
        os.utime(path, (1e9, 1e9))
    return tmp_path


def run(folder: Path) -> tuple[float, int]:
    """What the script in a folder prints: its result, and how many kernels came from disk."""
    package = str(Path(hydro.__path__[0]).parent)
    own = {"XDG_CACHE_HOME": str(folder / "cache"), "PYTHONPATH": package, "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(
        [sys.executable, "script.py"], cwd=folder, env=os.environ | own, capture_output=True, text=True, check=True
    )
    result, hits = done.stdout.split()
    return float(result), int(hits)


def test_a_change_of_a_users_module_or_of_what_it_imports_is_noticed(tree):
    assert run(tree) == (12.0, 0)
    assert run(tree) == (12.0, 1)
    edit(tree / "constants.py", "2.0", "3.0")  # of the same length, and the same age: only the content tells
    assert run(tree) == (16.0, 0)
    edit(tree / "law.py", "+ self", "- self")
    assert run(tree) == (8.0, 0)
    edit(tree / "constants.py", "3.0", "2.0")
    edit(tree / "law.py", "- self", "+ self")
    assert run(tree) == (12.0, 1)


def edit(path: Path, before: str, after: str) -> None:
    path.write_text(path.read_text().replace(before, after))
    os.utime(path, (1e9, 1e9))


def test_nothing_is_kept_of_a_file_that_changed_while_the_program_runs(tree, monkeypatch):
    monkeypatch.syspath_prepend(str(tree))
    importlib.import_module("law")
    assert tree / "constants.py" in kernel_cache.sources_of({"law"})
    os.utime(tree / "constants.py")
    assert kernel_cache.sources_of({"law"}) is None
    for name in ("law", "constants"):
        del sys.modules[name]


def test_nothing_is_kept_of_types_without_a_source():
    assert kernel_cache.sources_of({"no_such_module"}) is None


def test_a_folder_that_another_process_removes_meanwhile_does_no_harm(tmp_path, monkeypatch):
    for name in range(kernel_cache.KEPT + 3):
        (tmp_path / str(name)).mkdir()
    is_dir = Path.is_dir

    def gone(path: Path) -> bool:
        there = is_dir(path)
        if path.name == "1" and there:
            path.rmdir()
        return there

    monkeypatch.setattr(Path, "is_dir", gone)
    kernel_cache._prune(tmp_path)
    assert sum(1 for _ in tmp_path.iterdir()) == kernel_cache.KEPT
