"""What each kind of deck can do."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from hydro.check.scales import report
from hydro.kinds import branch, evolution, grains, stability, steady
from hydro.registry import Registry
from hydro.studies import convergence, sweep


class Kind(NamedTuple):
    """How a deck of one kind is run, and described without running it."""

    solve: Callable[..., dict[str, Any]]  # (deck, folder, quiet) -> summary
    describe: Callable[..., list[str]]  # (deck) -> lines of scales and warnings
    closing: Callable[[dict[str, Any]], list[str]]  # (summary) -> what a person wants to know at the end
    # (summary) -> numbers, those that its decks name included
    scalars: Callable[[dict[str, Any]], dict[str, Any]] = dict
    resume: Callable[..., dict[str, Any]] | None = None  # (deck, folder, quiet) -> summary: as solve, from where it was

    @property
    def goes_on(self) -> bool:
        """Whether running a deck again takes up what its folder has of that run."""
        return self.resume is self.solve


KINDS: Registry[Kind] = Registry("kind")
KINDS.add("evolution", Kind(evolution.solve, report, evolution.closing, evolution.scalars, evolution.resume))
KINDS.add("steady", Kind(steady.solve, steady.describe, steady.closing))
KINDS.add("branch", Kind(branch.solve, branch.describe, branch.closing, branch.scalars))
KINDS.add("stability", Kind(stability.solve, stability.describe, stability.closing, stability.scalars))
KINDS.add("grains", Kind(grains.solve, grains.describe, grains.closing, grains.scalars, grains.resume))
KINDS.add(
    "convergence",
    Kind(convergence.solve, convergence.describe, convergence.closing, convergence.scalars, convergence.solve),
)
KINDS.add("sweep", Kind(sweep.solve, sweep.describe, sweep.closing, resume=sweep.solve))
