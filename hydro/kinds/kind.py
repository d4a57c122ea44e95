"""What a kind of deck can do. Each kind has such a `KIND` in its file, and a line in `hydro.choices`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple


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
