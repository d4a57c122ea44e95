"""Named choices: a table for each, whose things are loaded when they are first used."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator, Mapping
from importlib import import_module
from typing import Any, NamedTuple, TypeVar

from hydro.own import is_own, own_part

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


class Entry(NamedTuple):
    """Where a thing is found that decks name, and the section with its keys, where that stands apart from it."""

    home: str  # "module:object"
    section: str  # "module:object"


class Registry(Mapping[str, T]):
    """A table from the names used in decks to the things they stand for, each given as "module:object".

    `asks` is the protocol, or base class, of what a deck may name of a user's own, as `file.py:Class`; without it
    there are only the names of the table. Methods of a `compiled` thing are called by kernels.

    >>> limits = Registry("limit", {"square root": "math:sqrt"})
    >>> limits["square root"](4.0)
    2.0
    """

    def __init__(self, kind: str, entries: Mapping[str, str | Entry], asks: str = "", compiled: bool = False):
        self.kind, self.asks, self.compiled = kind, asks, compiled
        self._entries = dict(entries)

    def __getitem__(self, name: str) -> T:
        if self.admits(name):
            return own_part(name, loaded(self.asks), self.compiled)
        entry = self._entry(name)
        return loaded(entry.home if isinstance(entry, Entry) else entry)

    def section(self, name: str) -> Any:
        """The section with the keys of a thing; the thing itself where none stands beside it."""
        entry = None if self.admits(name) else self._entry(name)
        return loaded(entry.section) if isinstance(entry, Entry) else self[name]

    def with_sections(self) -> list[str]:
        """Names of the things beside which a section stands."""
        return [name for name, entry in self._entries.items() if isinstance(entry, Entry)]

    def admits(self, name: str) -> bool:
        """Whether a name stands for a part of a user's own, which decks may use here."""
        return bool(self.asks) and is_own(name)

    __eq__, __hash__ = object.__eq__, object.__hash__  # by what it is, not by what it holds

    def _entry(self, name: str) -> str | Entry:
        try:
            return self._entries[name]
        except KeyError:
            raise UnknownName(self.kind, name, list(self)) from None

    def __contains__(self, name: object) -> bool:
        return name in self._entries

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)


def loaded(home: str) -> Any:
    """What "module:object" stands for."""
    module, _, name = home.partition(":")
    return getattr(import_module(module), name)
