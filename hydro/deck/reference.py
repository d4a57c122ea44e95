"""The reference of all deck keys, written from the models: `python -m hydro.deck.reference > docs/decks.md`."""

from __future__ import annotations

from collections.abc import Iterator, Set
from typing import Any, Literal, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt, MinLen

from hydro import markdown
from hydro.choices import KINDS
from hydro.deck.quantities import Quantity
from hydro.deck.sections import Deck
from hydro.schema import Chosen, Named, Section, choice_of, item_of, list_or, meaning, section_of

INTRODUCTION = """\
# Decks

Written by `python -m hydro.deck.reference` from the models of sections, which stand beside what they are for.

A deck is a TOML file. Its `kind` says what it asks for; everything else stands in sections.
Any key can be changed on the command line: `section.key=value`, for example `time.end=10 wall.kind=thermal`.
Where that switches the kind of a section, keys that only the other kinds know are dropped from it.
Numbers are scaled: length `L_x`, density `n_c`, temperature `T_*`, hence velocity `T_*^(1/2)`, time `L_x/T_*^(1/2)`,
pressure `n_c T_*`; each is zero or of a size between 1e-30 and 1e30. From a section `[experiment]` follow `gas.L`,
`gas.f`, `gas.K`, `gas.tau`, `gas.mu`, `box.aspect_ratio` and `wall.W`, or `stability.L` and `stability.points`, which
must not be given then ([experiment.md](experiment.md))."""

HEADER = ("key", "type", "default", "allowed", "meaning")
WORDS = {float: "number", int: "whole number", str: "text", bool: "true or false", Any: "value"}
BOUNDS = ((Gt, "gt", "> {}"), (Ge, "ge", ">= {}"), (Lt, "lt", "< {}"), (Le, "le", "<= {}"))


def reference() -> str:
    """The text of docs/decks.md: one table of keys for each section of each kind of deck."""
    return "\n\n".join([INTRODUCTION, *(block for kind in KINDS for block in _deck(kind))]) + "\n"


def _deck(kind: str) -> Iterator[str]:
    model = KINDS.section(kind)
    yield f'## kind = "{kind}"'
    yield model.__doc__ or ""
    for name in model.model_fields:
        yield from _section(model, name, name, level=3)


def _section(owner: type[Section], key: str, name: str, level: int) -> Iterator[str]:
    """Heading, text and table of the section `key` of `owner`; nothing for a plain key."""
    choice, model = choice_of(owner, key), section_of(owner, key)
    if choice is not None:
        yield f"{'#' * level} [{name}]"
        yield from _chosen(owner, key, choice, name, level)
    elif model is not None:
        yield f"{'#' * level} [{name}]"
        yield from _keys(model, name, level)
    elif (item := item_of(owner, key)) is not None:
        yield f"{'#' * level} [[{name}]]"
        yield from _keys(item, name, level)
    elif (instead := list_or(owner, key)) is not None:
        yield f"{'#' * level} [{name}], instead of a list"
        yield from _keys(instead, name, level)


def _chosen(owner: type[Section], key: str, choice: Chosen, name: str, level: int) -> Iterator[str]:
    """Text and tables of a section that depends on a choice: the keys that all have, and those of each."""
    shared: set[str] = set()
    if choice.key == "kind":
        yield f"{meaning(owner, key)}. Default: {_default(owner, key)}.".replace("Default: required", "Required")
        shared = {"kind"}
    elif choice.shared is not None:
        yield from _keys(choice.shared, name, level)
        shared = set(choice.shared.model_fields)
    if all(issubclass(model, Deck) for model in choice.models.values()):
        yield f"Its `kind` is {', '.join(f'`{kind}`' for kind in choice.names)}, with the keys of such a deck."
        return
    if choice.only is None and choice.table.asks:
        yield f"`{choice.key}` may also name one of your own, `file.py:Class` ([extending.md](extending.md))."
    for kind, model in choice.models.items():
        yield f'{"#" * (level + 1)} [{name}] {choice.key} = "{kind}"'
        yield from _keys(model, name, level + 1, shared)


def _keys(model: type[Section], name: str, level: int, but: Set[str] = frozenset()) -> Iterator[str]:
    """Text of a section and table of its keys, but for some, and the sections in it."""
    yield model.__doc__ or ""
    rows = [_row(model, key) for key in model.model_fields if key not in but]
    if rows:
        yield markdown.table(HEADER, rows)
    for key in model.model_fields:
        yield from _section(model, key, f"{name}.{key}", level + 1)


def _row(model: type[Section], key: str) -> tuple[str, ...]:
    field = model.model_fields[key]
    choice = choice_of(model, key)
    kind_of_value = "section" if choice else _type(field.annotation)
    kind_of_value += " or section" if list_or(model, key) else ""
    found = choice.names if choice else [*_allowed(field.metadata), *_allowed_in(field.annotation)]
    return f"`{key}`", kind_of_value, _default(model, key), ", ".join(dict.fromkeys(found)), meaning(model, key)


def _type(annotation: Any) -> str:
    """An annotation in words."""
    if isinstance(annotation, type) and issubclass(annotation, Section):
        return "section"
    if get_origin(annotation) is Literal:
        return "text"
    inner = [part for part in get_args(annotation) if part not in (type(None), Ellipsis)]
    if get_origin(annotation) is not tuple:
        return _type(inner[0]) if inner else WORDS[annotation]
    count = "" if Ellipsis in get_args(annotation) else f"{len(inner)} "
    return f"list of {count}{_type(inner[0])}s".replace("texts", "names")


def _allowed(metadata: Any) -> Iterator[str]:
    """Bounds and names in the metadata of a field, flattened."""
    for item in metadata:
        yield from _allowed(getattr(item, "metadata", ()))
        yield from (words.format(getattr(item, name)) for bound, name, words in BOUNDS if isinstance(item, bound))
        if isinstance(item, Named):
            yield from (f"`{name}`" for name in item.names)
        if isinstance(item, Quantity):
            yield f'{item.name}, such as `"{item.example}"`'
        if isinstance(item, MinLen):
            yield f"length >= {item.min_length}"


def _allowed_in(annotation: Any) -> Iterator[str]:
    """Bounds and names of the items of a list, and of what may also be None."""
    yield from _allowed(getattr(annotation, "__metadata__", ()))
    if get_origin(annotation) is Literal:
        yield from (f"`{name}`" for name in get_args(annotation))
        return
    parts = [part for part in dict.fromkeys(get_args(annotation)) if part not in (type(None), Ellipsis)]
    parts = [part for part in parts if not (isinstance(part, type) and issubclass(part, Section))]
    if len(parts) == 1:  # items that differ from each other are told apart by the description
        yield from _allowed_in(parts[0])


def _default(model: type[Section], key: str) -> str:
    field = model.model_fields[key]
    if field.is_required():
        return "required"
    if isinstance(field.default, dict):
        return ", ".join(f'`{key} = "{value}"`' for key, value in field.default.items()) or "none"
    if field.default in (None, ""):
        return "none"
    if isinstance(field.default, bool):
        return f"`{str(field.default).lower()}`"
    return f"`{list(field.default) if isinstance(field.default, tuple) else field.default!r}`".replace("'", '"')


if __name__ == "__main__":
    print(reference(), end="")
