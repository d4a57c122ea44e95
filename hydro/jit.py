"""Compilation: how a function becomes a kernel, and where the machine code is kept.

Decorators: `kernel` compiles a function over arrays and caches the result on disk; `part` and `inline` do so for
its parts; `compiled_methods` makes the methods of a NamedTuple callable inside kernels: a closure, limiter or Riemann solver is written
once, as a class of plain arithmetic, and works on numpy arrays as it stands and inside kernels specialized
for it. The choice is made by type while compiling, so it costs nothing while running.
"""

from __future__ import annotations

import contextlib
import hashlib
import inspect
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba import types
from numba.extending import overload_method

C = TypeVar("C", bound=type)

# Without "nnan" and "ninf": a NaN must stay a NaN, for it is how an inadmissible state shows itself.
FASTMATH = {"contract", "arcp", "nsz", "reassoc", "afn"}
OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": FASTMATH}
# Loops that say `prange` run in parallel, and nothing else: array expressions are not worth the compile time.
PRANGE_ONLY = {
    name: name == "prange"
    for name in ("prange", "numpy", "reduction", "setitem", "comprehension", "inplace_binop", "stencil", "fusion")
}
KEPT_CACHES = 3
KERNEL_SOURCES = ("jit.py", "walls.py", "gas/*.py", "dynamics/*.py")  # every file that ends up in machine code


def kernel(function: Callable | None = None, *, parallel: bool = False) -> Any:
    """Compile `function` for arrays, cached on disk; `parallel=True` runs its `prange` loops on all cores."""
    if function is None:
        return lambda wrapped: kernel(wrapped, parallel=parallel)
    with _cache_directory():
        return numba.njit(cache=True, nogil=True, parallel=PRANGE_ONLY if parallel else False, **OPTIONS)(function)


def part(function: Callable) -> Any:
    """Compile a part of a kernel, that only kernels call: cheaper than `kernel`, for Python cannot call it."""
    with _cache_directory():
        return numba.njit(cache=True, no_cpython_wrapper=True, no_cfunc_wrapper=True, **OPTIONS)(function)


def inline(function: Callable) -> Any:
    """Compile a small scalar function that is always inlined into the kernels that call it."""
    return numba.njit(forceinline=True, **OPTIONS)(function)


def compiled_methods(cls: C) -> C:
    """Make the public methods of the NamedTuple `cls` callable inside kernels. The tuple needs a field or more."""
    inherited = set(dir(tuple)) | set(cls._fields)  # type: ignore[attr-defined]
    for name in dir(cls):
        if not name.startswith("_") and name not in inherited:
            _overload(name, inspect.signature(getattr(cls, name)))
    return cls


@lru_cache(maxsize=None)
def _overload(name: str, signature: inspect.Signature) -> None:
    """Teach the compiler the method `name` of any NamedTuple whose class defines it."""

    def implementation(self, *arguments):  # noqa: ANN001, ANN002, ANN202
        method = getattr(self.instance_class, name, None)
        return method if method is not None and inspect.signature(method) == signature else None

    implementation.__signature__ = signature  # type: ignore[attr-defined]
    overload_method(types.BaseNamedTuple, name, jit_options={"forceinline": True, **OPTIONS})(implementation)


@contextlib.contextmanager
def _cache_directory() -> Iterator[None]:
    """Numba checks only a kernel's own file for changes; a directory per source digest covers what it calls."""
    before = numba.config.CACHE_DIR  # type: ignore[attr-defined]
    numba.config.CACHE_DIR = before or str(_digest_directory())  # type: ignore[attr-defined]
    try:
        yield
    finally:
        numba.config.CACHE_DIR = before  # type: ignore[attr-defined]


@lru_cache(maxsize=None)
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
    """Keep the machine code of the newest few versions of the sources."""
    by_age = sorted((path for path in root.iterdir() if path.is_dir()), key=lambda path: path.stat().st_mtime)
    for stale in by_age[:-KEPT_CACHES]:
        shutil.rmtree(stale, ignore_errors=True)
