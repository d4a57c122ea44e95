"""Classes whose methods kernels call: closures, walls, limiters, Riemann solvers.

Such a class is written once, as a NamedTuple of plain arithmetic, and works on numpy arrays as it stands and inside
kernels specialized for it. The choice is made by type while compiling, so it costs nothing while running.

Here the classes are only noted. `hydro.jit` teaches the compiler what was noted when it is imported, and at once from
then on: a deck that names a closure does not wait for the compiler.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

C = TypeVar("C", bound=type)

_noted: dict[type, bool] = {}  # and whether their arithmetic is exact
_teachers: list[Callable[[type, bool], None]] = []


def compiled_methods(cls: C | None = None, *, exact: bool = False) -> Any:
    """Make the public methods of the NamedTuple `cls` callable inside kernels. The tuple needs a field or more.

    `exact=True` forbids the compiler to rearrange their arithmetic.
    """
    if cls is None:
        return lambda wrapped: compiled_methods(wrapped, exact=exact)
    _noted[cls] = exact
    for teach in _teachers:
        teach(cls, exact)
    return cls


def is_noted(cls: type) -> bool:
    """Whether kernels can call the methods of a class."""
    return cls in _noted


def teach_all(teach: Callable[[type, bool], None]) -> None:
    """Have `teach(cls, exact)` called for every class that is noted, now and later."""
    _teachers.append(teach)
    for cls, exact in _noted.items():
        teach(cls, exact)
