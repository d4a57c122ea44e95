"""Where compiled kernels are kept on disk, and how that stays right.

Numba's own cache has two gaps. It looks only at a kernel's own file for changes, not at what the kernel calls:
here a folder per digest of all kernel sources covers that. And its index cannot be read where a type in it cannot
be imported: a closure that a user wrote in a script would stop every other program. Here kernels that were
specialized for such types have a folder per module, and an index that cannot be read counts as empty.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numba
from numba import types
from numba.core.caching import FunctionCache

KERNEL_SOURCES = (
    "jit.py",
    "mesh.py",
    "walls.py",
    "gas/*.py",
    "dynamics/*.py",
    "grains/*.py",
)  # every file that ends up in machine code
KEPT = 3  # versions of the sources whose machine code is kept


class KernelCache(FunctionCache):
    """The cached machine code of one kernel, for all signatures."""

    def __init__(self, function: Callable, module: str = ""):
        with _cache_directory(module):
            super().__init__(function)
        self._function = function
        self._of_modules: dict[str, KernelCache] = {}

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled kernel for a signature, or None."""
        return self._of(sig)._guarded(FunctionCache.load_overload, sig, target_context)

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a compiled kernel."""
        self._of(sig)._guarded(FunctionCache.save_overload, sig, data)

    def _guarded(self, method: Callable, *arguments: Any) -> Any:
        """What the method gives; None, and an empty index, if that is not readable."""
        try:
            return method(self, *arguments)
        except Exception:
            self.flush()
            return None

    def _of(self, sig: Any) -> KernelCache:
        """The cache for a signature: this one, or that of the modules whose types it has."""
        modules = "+".join(sorted(foreign_modules(sig)))
        if not modules:
            return self
        if modules not in self._of_modules:
            self._of_modules[modules] = KernelCache(self._function, modules)
        return self._of_modules[modules]


def foreign_modules(sig: Any) -> set[str]:
    """Modules outside this package that define a NamedTuple among the types of a signature."""
    modules, waiting = set(), list(sig)
    while waiting:
        kind = waiting.pop()
        if isinstance(kind, types.BaseNamedTuple):
            modules.add(kind.instance_class.__module__)
            waiting.extend(kind)
    return {module for module in modules if module.split(".")[0] != __package__}


@contextlib.contextmanager
def _cache_directory(module: str) -> Iterator[None]:
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(Path(before or _digest_directory()) / module)
    try:
        yield
    finally:
        numba.config.CACHE_DIR = before


@cache
def _digest_directory() -> Path:
    digest = hashlib.sha256()
    for pattern in KERNEL_SOURCES:
        for source in sorted(Path(__file__).parent.glob(pattern)):
            digest.update(source.read_bytes())
    directory = _cache_root() / digest.hexdigest()[:16]
    directory.mkdir(parents=True, exist_ok=True)
    os.utime(directory)
    _prune(directory.parent)
    return directory


def _cache_root() -> Path:
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser())
    root = home / "hydro"
    try:
        root.mkdir(parents=True, exist_ok=True)
        writable = os.access(root, os.W_OK)
    except OSError:
        writable = False
    return root if writable else Path(tempfile.gettempdir()) / f"hydro-{os.getuid()}"


def _prune(root: Path) -> None:
    """Forget all but the newest few versions of the sources."""
    by_age = sorted((path for path in root.iterdir() if path.is_dir()), key=lambda path: path.stat().st_mtime)
    for stale in by_age[:-KEPT]:
        shutil.rmtree(stale, ignore_errors=True)
