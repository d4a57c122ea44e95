"""From a validated deck to TOML text that gives it again."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import tomli_w

from hydro.deck.sections import Deck


def dumps(deck: Deck) -> str:
    """The deck as TOML text, defaults included; `parse` of it gives an equal deck.

    What follows from other parts of it comes as comments at the end.
    """
    return _toml(given(deck)) + "".join(f"{line}\n" for line in _following(deck))


def given(deck: Deck) -> dict[str, Any]:
    """What the deck says, without what follows from other parts of it."""
    said = deck.model_dump(exclude_none=True)
    for sections in deck.follows.values():
        for name, keys in sections.items():
            said[name] = {key: value for key, value in said[name].items() if key not in keys}
    base = getattr(deck, "base", None)
    return said if base is None else {**said, "base": given(base)}


def toml_value(value: object) -> str:
    """A value as TOML, in one line."""
    line = _toml({"v": [[value]]})  # a section stays inline in a list of lists
    return line.strip().removeprefix("v = [[").removesuffix("]]")


def origin(key: str) -> str:
    """A section or key from which others follow, as people write it."""
    return key if "." in key else f"[{key}]"


def _toml(table: dict[str, Any]) -> str:
    """A table as TOML, with every list in one line: a line break in text is an escape, so only lists have them."""
    text = tomli_w.dumps(table)
    for break_up, joined in ((r"\[\n +", "["), (r",\n *\]", "]"), (r",\n +", ", ")):
        text = re.sub(break_up, joined, text)
    return text


def _following(deck: Deck) -> Iterator[str]:
    for source, sections in deck.follows.items():
        yield f"\n# What follows from {origin(source)}:"
        for name, keys in sections.items():
            yield from (f"# {name}.{key} = {toml_value(value)}" for key, value in keys.items())
    experiment = getattr(deck, "experiment", None)
    if experiment is not None:
        yield "# Units:"
        yield from (f"# {name} = {value:.6g} {unit}" for name, (value, unit) in experiment.units.items())
