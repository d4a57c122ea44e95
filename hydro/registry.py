"""Named choices: what a deck may say, in one table per kind of thing."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Iterator
from typing import Generic, TypeVar

T = TypeVar("T")


class UnknownName(KeyError):
    """A name that a registry does not hold; knows the allowed names and the nearest one."""

    def __init__(self, kind: str, name: str, allowed: list[str]):
        self.kind, self.name, self.allowed = kind, name, allowed
        self.nearest = nearest(name, allowed)
        super().__init__(name)

    def __str__(self) -> str:
        hint = f"; did you mean {self.nearest!r}?" if self.nearest else ""
        return f"unknown {self.kind} {self.name!r}; known: {', '.join(self.allowed)}{hint}"


def nearest(name: str, allowed: Iterable[str]) -> str | None:
    """The allowed name closest in spelling to `name`, or None when nothing is close."""
    lowered = {known.lower(): known for known in allowed}
    close = difflib.get_close_matches(name.lower(), lowered, n=1, cutoff=0.5)
    return lowered[close[0]] if close else None


class Registry(Generic[T]):
    """A table from the names used in decks to the things they stand for.

    >>> colours = Registry("colour")
    >>> @colours.register("red")
    ... def red(): ...
    >>> colours["red"] is red
    True
    """

    def __init__(self, kind: str):
        self.kind = kind
        self._entries: dict[str, T] = {}

    def register(self, name: str) -> Callable[[T], T]:
        """Decorator that enters the decorated thing under `name`; ValueError when the name is taken."""

        def enter(entry: T) -> T:
            self.add(name, entry)
            return entry

        return enter

    def add(self, name: str, entry: T) -> None:
        """Enter `entry` under `name`; ValueError when the name is taken."""
        if name in self._entries:
            raise ValueError(f"{self.kind} {name!r} is registered twice")
        self._entries[name] = entry

    def __getitem__(self, name: str) -> T:
        try:
            return self._entries[name]
        except KeyError:
            raise UnknownName(self.kind, name, list(self)) from None

    def __contains__(self, name: object) -> bool:
        return name in self._entries

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def items(self) -> Iterable[tuple[str, T]]:
        return self._entries.items()
