"""Values that the command line, a study or a base deck puts into a deck before it is checked."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from hydro.choices import KINDS
from hydro.deck.complaints import is_unicode, printable
from hydro.errors import Complaint, DeckError
from hydro.schema import Chosen, Section, choice_of, model_in

Keys = tuple[str, ...]  # the way to a value from the top of the deck

DECKS = Chosen(KINDS)  # what a deck is, by its kind


def override(data: dict[str, Any], overrides: Iterable[str]) -> list[Complaint]:
    """Change `data` in place; what is wrong with the overrides themselves comes back as complaints."""
    settings: list[tuple[Keys, Any]] = []
    complaints: list[Complaint] = []
    for argument in overrides:
        try:
            settings.append(_setting(argument))
        except DeckError as error:
            complaints += error.complaints
    return complaints + put_all(data, settings)


def put_all(data: dict[str, Any], settings: Sequence[tuple[Keys, Any]]) -> list[Complaint]:
    """Put values into `data`; what cannot be put comes back as complaints."""
    complaints: list[Complaint] = []
    _switch_choices(data, dict(settings))
    for keys, value in settings:
        try:
            _put(data, keys, value)
        except DeckError as error:
            complaints += error.complaints
    return complaints


def _setting(argument: str) -> tuple[Keys, Any]:
    """The keys and the value that `section.key=value` asks for."""
    shown = printable(argument)
    name, equals, text = argument.partition("=")
    keys = tuple(key.strip() for key in name.split("."))
    if not is_unicode(argument) or not equals or not all(keys):
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


def _switch_choices(data: dict[str, Any], settings: Mapping[Keys, Any]) -> None:
    """Where `settings` change what a section is, drop from it what only others know."""
    deck = DECKS.model_in({**data, "kind": settings.get(("kind",), data.get("kind"))})
    for keys in sorted((keys for keys in settings if len(keys) > 1), key=len):
        section, choice = _chosen_section(data, keys[:-1], deck)
        if choice is None or choice.key != keys[-1] or choice.name_in(section) in (None, settings[keys]):
            continue
        before = choice.model_in(section)
        section[choice.key] = settings[keys]
        _drop_foreign_keys(section, choice, before)


def _chosen_section(
    data: dict[str, Any], keys: Keys, deck: type[Section] | None
) -> tuple[dict[str, Any], Chosen | None]:
    """The section at `keys` and the choice that it depends on; empty and None where there is none."""
    section: Any = data
    model, choice = deck, None
    for key in keys:
        section = section.get(key)
        if model is None or not isinstance(section, dict):
            return {}, None
        choice, model = choice_of(model, key), model_in(model, key, section)
    return section, choice


def _drop_foreign_keys(section: dict[str, Any], choice: Chosen, before: type[Section] | None) -> None:
    model = choice.model_in(section)
    if model is not None:
        others = [*choice.models.values(), *([] if before is None else [before])]
        foreign = {key for other in others for key in other.model_fields} - set(model.model_fields)
        for key in foreign & set(section):
            del section[key]
