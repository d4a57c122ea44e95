"""Parts of a user's own, which a deck names as `file.py:Class`, a path relative to the deck.

The file is run when the deck is read. Its module is named after its content, so that kernels made for it are found
again, and those of another version are not.
"""

from __future__ import annotations

import hashlib
import importlib.util
import re
import sys
import traceback
from pathlib import Path
from types import ModuleType
from typing import Any

from hydro.methods import is_noted

OWN = re.compile(r"([^\n]+\.py):([^\W\d]\w*)")
NAMED = 4  # of what is missing


class Unusable(ValueError):
    """What a deck names of a user's own cannot be used, and why."""


def is_own(name: object) -> bool:
    """Whether a name is of the form `file.py:Class`."""
    return isinstance(name, str) and OWN.fullmatch(name) is not None


def anchored(name: str, folder: Path) -> str:
    """`file.py:Class` with the whole path of the file, which is relative to a folder."""
    file, _, part = name.rpartition(":")
    return f"{(folder / file).absolute()}:{part}"


def own_part(name: str, asked: Any, compiled: bool) -> Any:
    """The class that `file.py:Class` names; Unusable if it is not what is `asked`.

    asked: a protocol whose methods it must have, or a class from which it must derive. `compiled` ones must be
    NamedTuples whose methods kernels may call.
    """
    file, _, wanted = name.rpartition(":")
    module = own_module(Path(file))
    part = getattr(module, wanted, None)
    if not isinstance(part, type):
        classes = [key for key, value in vars(module).items() if getattr(value, "__module__", "") == module.__name__]
        raise Unusable(f"{file} has no class {wanted}; it has {', '.join(classes) or 'none'}")
    if compiled and not (issubclass(part, tuple) and hasattr(part, "_fields")):
        raise Unusable(f"{wanted} must be a NamedTuple of its constants, or derive from one")
    if compiled and not is_noted(part):
        raise Unusable(f"{wanted} must stand under the decorator hydro.methods.compiled_methods")
    if not getattr(asked, "_is_protocol", False):
        if not issubclass(part, asked):
            raise Unusable(f"{wanted} must derive from {asked.__module__}.{asked.__name__}")
        return part
    missing = [key for key in vars(asked) if not key.startswith("_") and not hasattr(part, key)]
    if missing:
        more = f" and {len(missing) - NAMED} more" if len(missing) > NAMED else ""
        lacking = f"{', '.join(missing[:NAMED])}{more}"
        raise Unusable(f"{wanted} lacks {lacking}: see {asked.__module__}.{asked.__name__}")
    return part


def own_module(path: Path) -> ModuleType:
    """The module in a file, run once for each content of it; Unusable where that fails."""
    try:
        content = path.read_bytes()
    except (OSError, ValueError) as error:
        raise Unusable(f"{path} cannot be read: {getattr(error, 'strerror', error)}") from None
    name = f"{path.stem}_{hashlib.sha256(content).hexdigest()[:16]}"
    if name not in sys.modules:
        spec: Any = importlib.util.spec_from_file_location(name, path)
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        try:
            spec.loader.exec_module(module)
        except (Exception, SystemExit) as error:
            del sys.modules[name]
            raise Unusable(f"{path} cannot be run: {described(error, path)}") from error
    return sys.modules[name]


def described(error: BaseException, path: Path) -> str:
    """An error in one line, with the line of the file that it comes from."""
    frames = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)]
    line = getattr(error, "lineno", None) or (frames[-1] if frames else None)
    where = f" (line {line})" if line else ""
    said = str(getattr(error, "msg", error)).partition("\n")[0]
    return f"{type(error).__name__}{': ' if said else ''}{said}{where}"
