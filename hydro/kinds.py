"""What each kind of deck can do."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from hydro.registry import Registry
from hydro.runs import branch, evolution, grains, stability, steady
from hydro.runs.scales import report


class Kind(NamedTuple):
    """How a deck of one kind is run, and described without running it."""

    solve: Callable[..., dict[str, Any]]  # (deck, folder, quiet) -> summary
    describe: Callable[..., list[str]]  # (deck) -> lines of scales and warnings
    closing: Callable[[dict[str, Any]], list[str]]  # (summary) -> what a person wants to know at the end


KINDS: Registry[Kind] = Registry("kind")
KINDS.add("evolution", Kind(evolution.solve, report, evolution.closing))
KINDS.add("steady", Kind(steady.solve, steady.describe, steady.closing))
KINDS.add("branch", Kind(branch.solve, branch.describe, branch.closing))
KINDS.add("stability", Kind(stability.solve, stability.describe, stability.closing))
KINDS.add("grains", Kind(grains.solve, grains.describe, grains.closing))
