"""Arithmetic of one step, counted: the kernels run uncompiled, on numbers that count what is done to them.

`python benchmarks/operations.py KIND N` prints, for N x N cells, operations per cell as JSON: sums (and differences),
products, divisions and roots.
"""

from __future__ import annotations

import json
import math
import operator
import os
import sys
from collections import Counter
from typing import Any

os.environ["NUMBA_DISABLE_JIT"] = "1"

import numpy as np

STEPS = 3
DONE: Counter[str] = Counter()
UNCOUNTED: dict[str, Any] = {"zeros": np.zeros, "empty": np.empty, "empty_like": np.empty_like, "inv": np.linalg.inv}


class Number:
    """A number that counts."""

    __slots__ = ("value",)

    def __init__(self, value: Any):
        self.value = float(value)

    def __float__(self) -> float:
        return self.value

    def __neg__(self) -> Number:
        return Number(-self.value)

    def __abs__(self) -> Number:
        return Number(abs(self.value))


def counting(kind: str, function: Any, turned: bool = False) -> Any:
    """An operation of numbers that is counted."""

    def operation(*operands):
        DONE[kind] += 1
        values = [float(one) for one in (reversed(operands) if turned else operands)]
        return Number(function(*values))

    return operation


for names, kind in (("add sub", "sums"), ("mul", "products"), ("truediv", "divisions"), ("pow", "powers")):
    for name in names.split():
        setattr(Number, f"__{name}__", counting(kind, getattr(operator, name)))
        setattr(Number, f"__r{name}__", counting(kind, getattr(operator, name), turned=True))
for name in ("lt", "le", "gt", "ge", "eq", "ne"):
    compare = getattr(operator, name)
    setattr(Number, f"__{name}__", lambda self, other, compare=compare: compare(self.value, float(other)))
for name, kind in (
    ("sqrt", "roots"),
    ("exp", "exponentials"),
    ("hypot", "roots"),
):  # numpy asks objects for these methods
    setattr(Number, name, counting(kind, getattr(math, name)))


def numbers(values: Any) -> np.ndarray:
    """An array of numbers that count."""
    return np.frompyfunc(Number, 1, 1)(np.asarray(values, dtype=float))


def array(shape: Any, dtype: Any = float, **_: Any) -> np.ndarray:
    """In place of numpy's empty arrays and zeros."""
    return numbers(UNCOUNTED["zeros"](shape)) if np.dtype(dtype).kind == "f" else UNCOUNTED["zeros"](shape, dtype)


def store_largest(values: np.ndarray, largest: np.ndarray, i: int) -> None:
    """In place of a kernel that reads bits."""
    largest[i] = max(values, key=float)


def count(kind: str, cells: int) -> dict[str, float]:
    """Operations per cell of the last of STEPS steps of a problem of `cases`."""
    from cases import problem

    for module in [module for name, module in sys.modules.items() if name.startswith("hydro.")]:
        if hasattr(module, "store_largest"):
            setattr(module, "store_largest", store_largest)  # noqa: B010
    state, _ = problem(cells, kind)
    np.zeros = np.empty = array  # type: ignore[assignment, misc]
    np.empty_like = np.zeros_like = lambda like, **_: array(np.shape(like))  # type: ignore[assignment]
    np.linalg.inv = lambda matrix: UNCOUNTED["inv"](matrix.astype(float))  # type: ignore[assignment]
    _, integrator = problem(cells, kind)
    state.conserved = numbers(state.conserved)
    for _ in range(STEPS):
        DONE.clear()
        integrator.step(state, float(integrator.largest_step(state)))
    return {name: DONE[name] / cells**2 for name in ("sums", "products", "divisions", "roots")}


if __name__ == "__main__":
    print(json.dumps(count(sys.argv[1], int(sys.argv[2]))))
