"""Where compiled kernels are kept on disk, and how that stays right.

Numba's own cache looks only at a kernel's own file for changes. Here machine code lies in a folder named after the
sources that can end up in it: the kernel's module, the modules of the closures, walls and limiters that it is
specialized for (the named tuples among its argument types), and all that these import, in this package and beside a
user's own module. The import statements say what that is, so a kernel may move to any file.

Neither the path nor the age of a source matters, so copies of this package share kernels. An index that cannot be read
counts as empty. Nothing is kept where the sources cannot be known: types made at a prompt, and files that were changed
while the program runs.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import sys
import sysconfig
import tempfile
import time
from collections.abc import Callable, Iterable
from functools import cache, partial
from pathlib import Path
from typing import Any

from numba import types
from numba.core.caching import CompileResultCacheImpl, FunctionCache, NullCache, _CacheLocator

IMPORTS = re.compile(r"^[ \t]*(?:from\s+([\w.]+)\s+import\s+(\([^)]*\)|[^\n#]*)|import\s+([^\n#]*))", re.MULTILINE)
LIBRARIES = tuple({sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")})
KEPT = 200  # folders of machine code, some 2 MB each; a version of the sources has about ten
STARTED = time.time()


class KernelCache(NullCache):
    """The cached machine code of one kernel, for all signatures."""

    def __init__(self, function: Callable):
        self._function = function
        self._by_modules: dict[frozenset[str], FunctionCache | None] = {}

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled kernel for a signature, or None."""
        return self._guarded(FunctionCache.load_overload, sig, target_context)

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a compiled kernel."""
        self._guarded(FunctionCache.save_overload, sig, data)

    def _guarded(self, method: Callable, sig: Any, *arguments: Any) -> Any:
        """What the method gives of the cache for a signature; None, and an empty index, if that is not readable."""
        modules = frozenset({self._function.__module__, *modules_of(sig)})
        if modules not in self._by_modules:
            folder = folder_of(modules)
            self._by_modules[modules] = InFolder(self._function, folder) if folder else None
        cached = self._by_modules[modules]
        if cached is None:
            return None
        try:
            return method(cached, sig, *arguments)
        except Exception:
            cached.flush()
            return None


class InFolder(FunctionCache):
    """Numba's cache of a function in a folder whose name stands for the contents of all sources."""

    def __init__(self, function: Callable, folder: Path):
        self._impl_class = partial(Placed, folder)
        super().__init__(function)


class Placed(CompileResultCacheImpl):
    """Writes and reads machine code in a folder."""

    def __init__(self, folder: Path, function: Callable):
        self._locator_classes = [Place(folder, function)]
        super().__init__(function)


class Place(_CacheLocator):
    """The place of a function in a folder; neither the path nor the age of its source matters."""

    def __init__(self, folder: Path, function: Callable):
        self._folder, self._name = str(folder), f"{function.__module__}-{function.__code__.co_firstlineno}"

    def from_function(self, py_func: Callable, py_file: str) -> Place:
        return self

    def get_cache_path(self) -> str:
        return self._folder

    def get_source_stamp(self) -> str:
        return ""

    def get_disambiguator(self) -> str:
        return self._name


def modules_of(sig: Any) -> set[str]:
    """Names of the modules that define the named tuples among the types of a signature."""
    modules, waiting = set(), list(sig)
    while waiting:
        kind = waiting.pop()
        if isinstance(kind, types.BaseNamedTuple):
            modules.add(kind.instance_class.__module__)
        if isinstance(kind, types.BaseTuple):
            waiting.extend(kind)
    return modules


@cache
def folder_of(modules: frozenset[str]) -> Path | None:
    """Where kernels made of these modules are kept; None if their sources are not known."""
    sources = sources_of(modules)
    if sources is None:
        return None
    root = _root()
    folder = root / digest_of(sources)
    folder.mkdir(exist_ok=True)
    os.utime(folder)
    _prune(root)
    return folder


def sources_of(modules: Iterable[str]) -> list[Path] | None:
    """The files of these modules and of all that they import; None if one has no source as old as this program."""
    found: dict[str, Path] = {}
    waiting = list(modules)
    while waiting:
        name = waiting.pop()
        if name in found:
            continue
        source = source_of(name)
        if source is None or source.stat().st_mtime > STARTED:
            return None
        found[name] = source
        waiting.extend(used for used in imports_of(source) if used not in found and belongs(used, name))
    return sorted(set(found.values()))


def source_of(name: str) -> Path | None:
    """The file of a module that is loaded, if it has one."""
    source = getattr(sys.modules.get(name), "__file__", None)
    return Path(source) if source and Path(source).is_file() else None


def belongs(used: str, name: str) -> bool:
    """Whether a name in an import of the module `name` is a module of the same package or of the user's own."""
    source = source_of(used)
    if source is None:
        return False
    return used.partition(".")[0] == name.partition(".")[0] or not str(source).startswith(LIBRARIES)


@cache
def imports_of(source: Path) -> frozenset[str]:
    """Names of all that a file imports and that may be modules: `from a.b import c` may mean `a`, `a.b`, `a.b.c`."""
    names: set[str] = set()
    for base, attributes, modules in IMPORTS.findall(source.read_text(encoding="utf-8")):
        names |= {base, *(f"{base}.{word}" for word in listed(attributes))} if base else listed(modules)
    return frozenset(
        ".".join(parts[:k]) for parts in (name.split(".") for name in names) for k in range(1, len(parts) + 1)
    )


def listed(clause: str) -> set[str]:
    """The names in `a, b as c` and the like."""
    return {name.split()[0] for name in clause.strip("() \n").split(",") if name.split()}


def digest_of(sources: Iterable[Path]) -> str:
    """A name for the contents of files, in their order."""
    digest = hashlib.sha256()
    for source in sources:
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


@cache
def _root() -> Path:
    named = os.environ.get("NUMBA_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME")
    root = Path(named or Path("~/.cache").expanduser()) / "hydro"
    try:
        root.mkdir(parents=True, exist_ok=True)
        writable = os.access(root, os.W_OK)
    except OSError:
        writable = False
    if not writable:
        root = Path(tempfile.gettempdir()) / f"hydro-{os.getuid()}"
        root.mkdir(exist_ok=True)
    return root


def _prune(root: Path) -> None:
    """Forget all but the folders that were used last."""
    ages = {path: age for path in root.iterdir() if (age := _age_of(path)) is not None}
    for stale in sorted(ages, key=ages.__getitem__)[:-KEPT]:
        shutil.rmtree(stale, ignore_errors=True)


def _age_of(folder: Path) -> float | None:
    """When a folder was used last; None for what is none, or was removed by another process meanwhile."""
    try:
        return folder.stat().st_mtime if folder.is_dir() else None
    except FileNotFoundError:
        return None
