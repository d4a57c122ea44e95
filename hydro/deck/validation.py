"""What a deck says, checked against the models of its sections, with what follows from it filled in."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from pydantic import ValidationError

from hydro.choices import KINDS
from hydro.deck.complaints import printable, show, translate, wrong_kind
from hydro.deck.overrides import DECKS, put_all
from hydro.deck.sections import Deck
from hydro.deck.writing import given, origin, toml_value
from hydro.errors import Complaint, DeckError
from hydro.schema import model_in


def validate(data: Mapping[str, Any], source: str = "deck", complaints: Iterable[Complaint] = ()) -> Deck:
    """The deck that nested dictionaries describe; DeckError with `complaints` and all that is wrong with `data`."""
    found = list(complaints)
    model: Any = DECKS.model_in(data)
    if model is None:
        raise DeckError([*found, wrong_kind("kind", data.get("kind"), KINDS)], source)
    data, following, doubled = _fill(data, model)
    found += doubled
    try:
        deck = model.model_validate(data)
        found += _wrong_members(deck)
    except ValidationError as error:
        found += [_blame(translate(entry, model, data), following) for entry in error.errors(include_url=False)]
    else:
        if not found:
            return deck
    raise DeckError(list({str(complaint): complaint for complaint in found}.values()), source)


def changed(deck: Deck, changes: Mapping[str, Any]) -> Deck:
    """The deck with other values at dotted keys, which may switch the kinds of sections; DeckError as for `load`."""
    data = given(deck)
    return validate(data, complaints=put_all(data, [(tuple(key.split(".")), value) for key, value in changes.items()]))


def _wrong_members(deck: Deck) -> Iterator[Complaint]:
    """What is wrong with the runs of a study, each thing once."""
    said: set[tuple[str, str]] = set()
    for number, changes in enumerate(deck.changes, start=1):
        try:
            changed(deck.base, changes)  # type: ignore[attr-defined]
        except DeckError as error:
            new = [complaint for complaint in error.complaints if (complaint.key, complaint.problem) not in said]
            said.update((complaint.key, complaint.problem) for complaint in new)
            shown = ", ".join(f"{printable(key) or '(empty)'} = {toml_value(value)}" for key, value in changes.items())
            yield from (replace(one, problem=f"{one.problem}, in member {number}: {shown}") for one in new)


# What follows from other parts of a deck


def _fill(data: Mapping[str, Any], model: type[Deck]) -> tuple[Mapping[str, Any], dict[str, str], list[Complaint]]:
    """`data` with all that follows from other parts of it.

    Beside it the keys of that, each with the one that it follows from, and complaints where they were given too.
    """
    inner = model_in(model, "base", data.get("base"))
    if inner is not None and issubclass(inner, Deck):
        base, following, doubled = _fill(data["base"], inner)
        blamed = [replace(complaint, key=f"base.{complaint.key}") for complaint in doubled]
        return {**data, "base": base}, {f"base.{key}": f"base.{source}" for key, source in following.items()}, blamed
    filled, following, doubled = dict(data), {}, []
    for source, sections in model.inferred(data).items():
        for name, keys in sections.items():
            default = model.model_fields[name].default
            section = data.get(name, {})
            if not isinstance(section, dict):
                continue
            section = {**default, **section} if isinstance(default, dict) else section
            found = model_in(model, name, section)
            known = {key: value for key, value in keys.items() if found is not None and key in found.model_fields}
            following |= dict.fromkeys((f"{name}.{key}" for key in known), source)
            doubled += [_doubled(f"{name}.{key}", section[key], source) for key in known if key in section]
            filled[name] = {**section, **known}
    return filled, following, doubled


def _doubled(key: str, value: object, source: str) -> Complaint:
    problem = f"{show(value)} is given beside {origin(source)}, from which it follows; leave one out"
    return Complaint(key, problem, value)


def _blame(complaint: Complaint, following: Mapping[str, str]) -> Complaint:
    """A complaint about what follows from another part of the deck as one about that."""
    source = following.get(complaint.key.partition("[")[0])
    if source is None:
        return complaint
    return Complaint(source, f"{complaint.key} follows from it: {complaint.problem}", complaint.value)
