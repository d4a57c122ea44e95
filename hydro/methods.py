"""What kernels call by name: methods of closures, walls, limiters and Riemann solvers, and formulas.

Such a class is written once, as a NamedTuple of plain arithmetic, and works on numpy arrays as it stands and inside
kernels specialized for it. The choice is made by type while compiling, so it costs nothing while running.

Here they are only noted. `hydro.jit` teaches the compiler what was noted when it is imported, and at once from
then on: a deck that names a closure does not wait for the compiler.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

C = TypeVar("C", bound=type)
F = TypeVar("F", bound=Callable)

_noted: dict[Any, bool] = {}  # classes and formulas, and whether their arithmetic is exact
_teachers: list[Callable[[Any, bool], None]] = []


def compiled_methods(cls: C | None = None, *, exact: bool = False) -> Any:
    """Make the public methods of the NamedTuple `cls` callable inside kernels. The tuple needs a field or more.

    `exact=True` forbids the compiler to rearrange their arithmetic.
    """
    if cls is None:
        return lambda wrapped: compiled_methods(wrapped, exact=exact)
    _note(cls, exact)
    return cls


def formula(function: F) -> F:
    """Let kernels use a function of one expression: it stands there as if written out, by exact arithmetic.

    To Python it stays what it is, a function of numbers or arrays.
    """
    _note(function, exact=True)
    return function


def _note(thing: Any, exact: bool) -> None:
    _noted[thing] = exact
    for teach in _teachers:
        teach(thing, exact)


def is_noted(cls: type) -> bool:
    """Whether kernels can call the methods of a class."""
    return cls in _noted


def teach_all(teach: Callable[[Any, bool], None]) -> None:
    """Have `teach(thing, exact)` called for every class and formula that is noted, now and later."""
    _teachers.append(teach)
    for thing, exact in _noted.items():
        teach(thing, exact)
