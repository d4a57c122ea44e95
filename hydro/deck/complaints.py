"""Complaints about a deck: what pydantic found, in our words."""

from __future__ import annotations

import re
import reprlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import takewhile
from typing import Any, get_args

from pydantic_core import ErrorDetails

from hydro.errors import Complaint
from hydro.registry import nearest
from hydro.schema import Section, choice_of, item_of, list_or, meaning, model_in, section_of

SECTION = "must be a section (a TOML table)"
PHRASES = {
    "greater_than": "must be greater than {gt:g}",
    "greater_than_equal": "must be at least {ge:g}",
    "less_than": "must be less than {lt:g}",
    "less_than_equal": "must be at most {le:g}",
    "finite_number": "must be finite",
    "float_type": "must be a number",
    "int_type": "must be a whole number",
    "bool_type": "must be true or false",
    "string_type": "must be text",
    "string_unicode": "must be valid text",
    "tuple_type": "must be a list",
    "too_long": "must have {max_length} items",
    "too_short": "must have {min_length} items or more",
    "model_type": SECTION,
    "model_attributes_type": SECTION,
    "rule": "{problem}",
}


def translate(entry: ErrorDetails, deck: type[Section], data: Mapping[str, Any]) -> Complaint:
    """What pydantic found in the data of a deck, in our words."""
    key, owner = _locate(entry["loc"], deck, data)
    if entry["type"] == "extra_forbidden":
        return _unknown_key(key, owner, deck, entry)
    return WRITERS.get(entry["type"], _not_allowed)(key, owner, entry)


def _locate(loc: tuple[int | str, ...], deck: type[Section], data: Any) -> tuple[str, type[Section]]:
    """The dotted key at pydantic's `loc` in the data of a deck, and the model that has it.

    Behind a list that may also be a section, `loc` says which of both it is.
    """
    key, owner, model, value = "", deck, deck, data
    either: type[Section] | None = None
    for part in loc:
        if either is not None:
            model, either = either if part == "section" else model, None
            continue
        value = _below(value, part)
        if isinstance(part, int):
            key += f"[{part}]"
            continue
        key += f".{part if part.isprintable() else ascii(part)}"
        owner, either = model, list_or(model, part)
        model = model_in(model, part, value) or item_of(model, part) or model
    return key.removeprefix("."), owner


def _below(value: Any, key: int | str) -> Any:
    """What a section or a list has at a key; None where it has nothing."""
    if isinstance(value, dict):
        return value.get(key)
    return value[key] if isinstance(value, list | tuple) and isinstance(key, int) and key < len(value) else None


def _unknown_key(key: str, owner: type[Section], deck: type[Section], entry: ErrorDetails) -> Complaint:
    name = str(entry["loc"][-1])
    names = {field.title or known: known for known, field in owner.model_fields.items()}
    names |= {known: known for known in owner.model_fields}
    close = nearest(name, names)
    homes = set(_homes(name, deck))
    hint = names[close] if close else homes.pop() if len(homes) == 1 and key not in homes else None
    return Complaint(key, f"unknown key; known: {', '.join(owner.model_fields)}", entry["input"], hint)


def _homes(name: str, deck: type[Section]) -> Iterator[str]:
    """Dotted keys of all that is called `name` in the sections of `deck`."""
    for section in deck.model_fields:
        choice, plain = choice_of(deck, section), section_of(deck, section)
        models = [plain] if plain is not None else [] if choice is None else choice.models.values()
        yield from (f"{section}.{name}" for model in models if name in model.model_fields)


def _missing(key: str, owner: type[Section], entry: ErrorDetails) -> Complaint:
    name = entry["loc"][-1]
    if isinstance(name, str):
        return Complaint(key, f"required: {meaning(owner, name)}")
    count = len(get_args(owner.model_fields[str(entry["loc"][-2])].annotation))
    return Complaint(key.rpartition("[")[0], f"must have {count} items", entry["input"])


def _not_known(key: str, owner: type[Section], entry: ErrorDetails) -> Complaint:
    context = entry["ctx"]
    key = f"{key}.{context['key']}" if context["key"] else key
    if context["problem"]:
        return Complaint(key, f"{show(context['value'])} cannot be used: {context['problem']}", context["value"])
    return wrong_kind(key, context["value"], context["known"])


def _not_listed(key: str, owner: type[Section], entry: ErrorDetails) -> Complaint:
    return wrong_kind(key, entry["input"], re.findall("'([^']*)'", entry["ctx"]["expected"]))


def wrong_kind(key: str, value: object, known: Iterable[str]) -> Complaint:
    """The complaint about a value, or None, that is no known name."""
    if value is None:
        return Complaint(key, f"required; known: {', '.join(known)}")
    hint = nearest(value, known) if isinstance(value, str) else None
    return Complaint(key, f"{show(value)} is not known; known: {', '.join(known)}", value, hint)


def _not_allowed(key: str, owner: type[Section], entry: ErrorDetails) -> Complaint:
    context = entry.get("ctx", {})
    blamed = _in_base(context.get("key"), key)
    value = context["value"] if blamed else entry["input"]
    problem = PHRASES.get(entry["type"], entry["msg"]).format(**context)
    if entry["type"] == "float_type" and isinstance(value, int) and not isinstance(value, bool):
        problem = "too large for a number"
    if value is not None:
        problem = f"{show(value)} is not allowed; {problem}"
    return Complaint(blamed or key, problem, value)


def _in_base(blamed: str | None, key: str) -> str | None:
    """The key that a base deck blames, from the top of the study that `key` is in."""
    depth = len(list(takewhile(lambda part: part == "base", key.split("."))))
    return "base." * depth + blamed if blamed else None


WRITERS: dict[str, Callable[[str, type[Section], ErrorDetails], Complaint]] = {
    "missing": _missing,
    "unknown_choice": _not_known,
    "literal_error": _not_listed,
}

_SHORT = reprlib.Repr()
_SHORT.maxlevel, _SHORT.maxstring, _SHORT.maxlong, _SHORT.maxother = 3, 60, 40, 60


def show(value: object) -> str:
    """A short text for any value that TOML can hold."""
    if isinstance(value, bool):
        return str(value).lower()
    try:
        return _SHORT.repr(value)
    except ValueError:  # Python refuses to write out integers of thousands of digits
        return "a huge number"


def is_unicode(text: str) -> bool:
    """Whether `text` is without the surrogates that stand for bytes which are none."""
    return text.encode(errors="ignore").decode() == text


def printable(text: str) -> str:
    """`text` with what cannot be shown escaped: command-line arguments may hold any bytes."""
    return "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in text)
