"""From deck files and command-line overrides to a validated deck."""

from __future__ import annotations

import reprlib
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import takewhile
from pathlib import Path
from typing import Any, get_args

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from hydro.deck.fields import Section, item_of, kinds_of, list_or, meaning, section_of
from hydro.deck.kinds import KINDS
from hydro.deck.sections import Deck
from hydro.deck.write import given, origin, toml_value
from hydro.errors import Complaint, DeckError
from hydro.registry import nearest

Keys = tuple[str, ...]  # the way to a value from the top of the deck
Table = Mapping[str, type[Section]]  # from kinds of a tagged section to their models

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


def load(path: str | Path, overrides: Iterable[str] = ()) -> Deck:
    """The deck in the TOML file `path`, changed by overrides `section.key=value`.

    Raises DeckError, with every complaint at once, when anything is wrong with file, overrides or deck.
    """
    source = _printable(str(path))
    return parse(_read(Path(path), source), overrides, source, Path(path).parent)


def parse(text: str, overrides: Iterable[str] = (), source: str = "deck", folder: Path | None = None) -> Deck:
    """As `load`, from TOML text; `source` names the deck in messages, base decks are looked for in `folder`."""
    data = _data(text, source)
    complaints = [*_include(data, KINDS, folder or Path()), *_override(data, overrides)]
    return validate(data, source, complaints)


def changed(deck: Deck, changes: Mapping[str, Any]) -> Deck:
    """The deck with other values at dotted keys, which may switch the kinds of sections; DeckError as for `load`."""
    data = given(deck)
    return validate(data, complaints=_set(data, [(tuple(key.split(".")), value) for key, value in changes.items()]))


def validate(data: Mapping[str, Any], source: str = "deck", complaints: Iterable[Complaint] = ()) -> Deck:
    """The deck that nested dictionaries describe; DeckError with `complaints` and all that is wrong with `data`."""
    found = list(complaints)
    kind = data.get("kind")
    if not isinstance(kind, str) or kind not in KINDS:
        raise DeckError([*found, _wrong_kind("kind", data, KINDS)], source)
    model = KINDS[kind]
    data, following, doubled = _fill(data, model)
    found += doubled
    try:
        deck = model.model_validate(data)
        found += _wrong_members(deck)
    except ValidationError as error:
        found += [_blame(_translate(entry, model), following) for entry in error.errors(include_url=False)]
    else:
        if not found:
            return deck
    raise DeckError(list({str(complaint): complaint for complaint in found}.values()), source)


def _data(text: str, source: str) -> dict[str, Any]:
    """What TOML text says; `source` names it in messages."""
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise DeckError("lists or tables are nested too deeply", source) from None
    except ValueError as error:
        last_line = len(text.splitlines())
        problem = str(error).replace("at end of document", f"at line {last_line}, the last")
        raise DeckError(f"not valid TOML: {problem}", source) from None


def _read(path: Path, source: str) -> str:
    try:
        return path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        raise DeckError(f"not UTF-8 text (at line {line})", source) from None
    except OSError as error:
        raise DeckError(f"cannot be read: {error.strerror}", source) from None
    except ValueError:
        raise DeckError("not the name of a file", source) from None


# Base decks


def _include(data: dict[str, Any], table: Table, folder: Path) -> list[Complaint]:
    """Put the files that `base` names in its place; what is wrong with the keys that change them comes back."""
    model, base = _kind_in(table, data), data.get("base")
    name = base.get("deck") if isinstance(base, dict) else base
    if model is None or "base" not in model.model_fields or not isinstance(name, str):
        return []
    path = folder / name
    inner = _data(_read(path, f"base {_printable(str(path))}"), f"base {_printable(str(path))}")
    complaints = _include(inner, kinds_of(model, "base") or {}, path.parent)
    if isinstance(base, dict):
        complaints += _set(inner, [(keys, value) for keys, value in _settings(base) if keys != ("deck",)])
    data["base"] = inner
    return complaints


def _settings(table: Mapping[str, Any], above: Keys = ()) -> Iterator[tuple[Keys, Any]]:
    """All values in nested tables with the ways to them."""
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _settings(value, (*above, key))
        else:
            yield (*above, key), value


def _wrong_members(deck: Deck) -> Iterator[Complaint]:
    """What is wrong with the runs of a study, each thing once."""
    said: set[tuple[str, str]] = set()
    for number, changes in enumerate(deck.changes, start=1):
        try:
            changed(deck.base, changes)  # type: ignore[attr-defined]
        except DeckError as error:
            new = [complaint for complaint in error.complaints if (complaint.key, complaint.problem) not in said]
            said.update((complaint.key, complaint.problem) for complaint in new)
            shown = ", ".join(f"{_printable(key) or '(empty)'} = {toml_value(value)}" for key, value in changes.items())
            yield from (replace(one, problem=f"{one.problem}, in member {number}: {shown}") for one in new)


# Overrides


def _override(data: dict[str, Any], overrides: Iterable[str]) -> list[Complaint]:
    """Change `data` in place; what is wrong with the overrides themselves comes back as complaints."""
    settings: list[tuple[Keys, Any]] = []
    complaints: list[Complaint] = []
    for argument in overrides:
        try:
            settings.append(_setting(argument))
        except DeckError as error:
            complaints += error.complaints
    return complaints + _set(data, settings)


def _set(data: dict[str, Any], settings: Sequence[tuple[Keys, Any]]) -> list[Complaint]:
    """Put values into `data`; what cannot be put comes back as complaints."""
    complaints: list[Complaint] = []
    _switch_kinds(data, dict(settings))
    for keys, value in settings:
        try:
            _put(data, keys, value)
        except DeckError as error:
            complaints += error.complaints
    return complaints


def _setting(argument: str) -> tuple[Keys, Any]:
    """The keys and the value that `section.key=value` asks for."""
    shown = _printable(argument)
    name, equals, text = argument.partition("=")
    keys = tuple(key.strip() for key in name.split("."))
    if not _is_unicode(argument) or not equals or not all(keys):
        raise DeckError("not an override; write section.key=value", shown)
    return keys, _value(text.strip(), shown)


def _value(text: str, argument: str) -> Any:
    """`text` as a TOML value, or as it is when it is a bare word or path."""
    try:
        parsed = tomllib.loads(f"v = {text}")
    except (ValueError, RecursionError):
        parsed = {}
    if parsed.keys() == {"v"}:
        return parsed["v"]
    if not text or text[0] in "[{\"'" or not text.isprintable():
        raise DeckError("the value is neither a TOML value nor a word", argument)
    return text


def _put(data: dict[str, Any], keys: Keys, value: Any) -> None:
    section = data
    for depth, key in enumerate(keys[:-1], start=1):
        section = section.setdefault(key, {})
        if not isinstance(section, dict):
            raise DeckError(f"{'.'.join(keys[:depth])} is not a section", ".".join(keys))
    section[keys[-1]] = value


def _switch_kinds(data: dict[str, Any], settings: Mapping[Keys, Any]) -> None:
    """Where `settings` change the kind of a tagged section, drop from it what only other kinds know."""
    deck = _kind_in(KINDS, {**data, "kind": settings.get(("kind",), data.get("kind"))})
    switches = {keys[:-1]: kind for keys, kind in settings.items() if keys[-1] == "kind" and len(keys) > 1}
    for keys in sorted(switches, key=len):
        section, table = _tagged_section(data, keys, deck)
        if "kind" in section and section["kind"] != switches[keys]:
            section["kind"] = switches[keys]
            _drop_foreign_keys(section, table)


def _tagged_section(data: dict[str, Any], keys: Keys, deck: type[Section] | None) -> tuple[dict[str, Any], Table]:
    """The tagged section at `keys` and its kinds; both empty when there is none."""
    section: Any = data
    model, table = deck, None
    for key in keys:
        if model is None:
            return {}, {}
        section = section.get(key)
        if not isinstance(section, dict):
            return {}, {}
        table = kinds_of(model, key)
        model = section_of(model, key) if table is None else _kind_in(table, section)
    return (section, table) if table else ({}, {})


def _kind_in(table: Mapping[str, type[Section]], section: Mapping[str, Any]) -> type[Section] | None:
    kind = section.get("kind")
    return table.get(kind) if isinstance(kind, str) else None


def _drop_foreign_keys(section: dict[str, Any], table: Table) -> None:
    model = _kind_in(table, section)
    if model is not None:
        foreign = {key for other in table.values() for key in other.model_fields} - set(model.model_fields)
        for key in foreign & set(section):
            del section[key]


# What follows from other parts of a deck


def _fill(data: Mapping[str, Any], model: type[Deck]) -> tuple[Mapping[str, Any], dict[str, str], list[Complaint]]:
    """`data` with all that follows from other parts of it.

    Beside it the keys of that, each with the one that it follows from, and complaints where they were given too.
    """
    inner = _kind_in(kinds_of(model, "base") or {}, data["base"]) if isinstance(data.get("base"), dict) else None
    if inner is not None and issubclass(inner, Deck):
        base, following, doubled = _fill(data["base"], inner)
        blamed = [replace(complaint, key=f"base.{complaint.key}") for complaint in doubled]
        return {**data, "base": base}, {f"base.{key}": f"base.{source}" for key, source in following.items()}, blamed
    filled, following, doubled = dict(data), {}, []
    for source, sections in model.inferred(data).items():
        for name, keys in sections.items():
            default = {"kind": model.model_fields[name].default.kind} if kinds_of(model, name) else {}
            section = data.get(name, {})
            if not isinstance(section, dict):
                continue
            section = {**default, **section}
            choice = _kind_in(kinds_of(model, name) or {}, section) or section_of(model, name)
            known = {key: value for key, value in keys.items() if choice is not None and key in choice.model_fields}
            following |= dict.fromkeys((f"{name}.{key}" for key in known), source)
            doubled += [_doubled(f"{name}.{key}", section[key], source) for key in known if key in section]
            filled[name] = {**section, **known}
    return filled, following, doubled


def _doubled(key: str, value: object, source: str) -> Complaint:
    problem = f"{_show(value)} is given beside {origin(source)}, from which it follows; leave one out"
    return Complaint(key, problem, value)


def _blame(complaint: Complaint, following: Mapping[str, str]) -> Complaint:
    """A complaint about what follows from another part of the deck as one about that."""
    source = following.get(complaint.key.partition("[")[0])
    if source is None:
        return complaint
    return Complaint(source, f"{complaint.key} follows from it: {complaint.problem}", complaint.value)


# Complaints


def _translate(entry: ErrorDetails, deck: type[Section]) -> Complaint:
    """What pydantic found, in our words."""
    key, owner = _locate(entry["loc"], deck)
    if entry["type"] == "extra_forbidden":
        return _unknown_key(key, owner, deck, entry)
    return WRITERS.get(entry["type"], _not_allowed)(key, owner, entry)


def _locate(loc: tuple[int | str, ...], deck: type[Section]) -> tuple[str, type[Section]]:
    """The dotted key at pydantic's `loc`, which also holds the kinds of tagged sections, and the model that has it."""
    key, owner, model = "", deck, deck
    table: Table | None = None
    for part in loc:
        if isinstance(part, int):
            key += f"[{part}]"
        elif table is not None:
            model, table = table[part], None
        else:
            key += f".{part if part.isprintable() else ascii(part)}"
            owner, table, model = model, _choices(model, part), section_of(model, part) or item_of(model, part) or model
    return key.removeprefix("."), owner


def _choices(model: type[Section], key: str) -> Table | None:
    """What pydantic may say behind `key` of `model` to tell its kinds, or a list from a section, apart."""
    section = list_or(model, key)
    return kinds_of(model, key) if section is None else {"list": model, "section": section}


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
        plain = section_of(deck, section)
        models = (kinds_of(deck, section) or {}).values() if plain is None else [plain]
        yield from (f"{section}.{name}" for model in models if name in model.model_fields)


def _missing(key: str, owner: type[Section], entry: ErrorDetails) -> Complaint:
    name = entry["loc"][-1]
    if isinstance(name, str):
        return Complaint(key, f"required: {meaning(owner, name)}")
    count = len(get_args(owner.model_fields[str(entry["loc"][-2])].annotation))
    return Complaint(key.rpartition("[")[0], f"must have {count} items", entry["input"])


def _unknown_name(key: str, owner: type[Section], entry: ErrorDetails) -> Complaint:
    return _unknown_choice(key, entry["input"], entry["ctx"]["known"])


def _unknown_tag(key: str, owner: type[Section], entry: ErrorDetails) -> Complaint:
    return _wrong_kind(f"{key}.kind", entry["input"], kinds_of(owner, str(entry["loc"][-1])) or {})


def _wrong_kind(key: str, section: Mapping[str, Any], table: Table) -> Complaint:
    if "kind" not in section:
        return Complaint(key, f"required; known: {', '.join(table)}")
    return _unknown_choice(key, section["kind"], table)


def _unknown_choice(key: str, value: object, known: Iterable[str]) -> Complaint:
    hint = nearest(value, known) if isinstance(value, str) else None
    return Complaint(key, f"{_show(value)} is not known; known: {', '.join(known)}", value, hint)


def _not_allowed(key: str, owner: type[Section], entry: ErrorDetails) -> Complaint:
    context = entry.get("ctx", {})
    blamed = _in_base(context.get("key"), key)
    value = context["value"] if blamed else entry["input"]
    problem = PHRASES.get(entry["type"], entry["msg"]).format(**context)
    if entry["type"] == "float_type" and isinstance(value, int) and not isinstance(value, bool):
        problem = "too large for a number"
    if value is not None:
        problem = f"{_show(value)} is not allowed; {problem}"
    return Complaint(blamed or key, problem, value)


def _in_base(blamed: str | None, key: str) -> str | None:
    """The key that a base deck blames, from the top of the study that `key` is in."""
    depth = len(list(takewhile(lambda part: part == "base", key.split("."))))
    return "base." * depth + blamed if blamed else None


WRITERS: dict[str, Callable[[str, type[Section], ErrorDetails], Complaint]] = {
    "missing": _missing,
    "unknown_name": _unknown_name,
    "union_tag_invalid": _unknown_tag,
    "union_tag_not_found": _unknown_tag,
}

_SHORT = reprlib.Repr()
_SHORT.maxlevel, _SHORT.maxstring, _SHORT.maxlong, _SHORT.maxother = 3, 60, 40, 60


def _show(value: object) -> str:
    """A short text for any value that TOML can hold."""
    if isinstance(value, bool):
        return str(value).lower()
    try:
        return _SHORT.repr(value)
    except ValueError:  # Python refuses to write out integers of thousands of digits
        return "a huge number"


def _is_unicode(text: str) -> bool:
    """Whether `text` is without the surrogates that stand for bytes which are none."""
    return text.encode(errors="ignore").decode() == text


def _printable(text: str) -> str:
    """`text` with what cannot be shown escaped: command-line arguments may hold any bytes."""
    return "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in text)
