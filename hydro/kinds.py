"""What runs a deck of each kind: solve(deck, folder, quiet) -> summary."""

from collections.abc import Callable
from typing import Any

from hydro.registry import Registry
from hydro.runs import evolution

SOLVERS: Registry[Callable[..., dict[str, Any]]] = Registry("kind")
SOLVERS.add("evolution", evolution.solve)
