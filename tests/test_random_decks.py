"""Decks and overrides at random, by the thousand: `check` accepts them or refuses them by name.

Decks are generated from their models: the right keys, of the right types and within their bounds up to the ends of the
floating-point numbers, and then, in some, something is spoiled.
"""

from __future__ import annotations

import collections
import json
import math
import re
import tomllib
from collections.abc import Iterator
from datetime import date
from functools import cache
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from conftest import PROBLEMS
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from hydro.choices import KINDS
from hydro.cli import main
from hydro.schema import LARGEST, Chosen, Named, Section, choice_of, item_of, list_or, section_of

AT_RANDOM = settings(
    max_examples=2000,
    derandomize=True,
    deadline=None,
    phases=[Phase.generate],
    suppress_health_check=list(HealthCheck),
)
SMALL = {"cells": 24, "wave": 24, "waves": 24, "count": 24, "samples": 24, "points": 24}  # values that cost memory
ASKED_FOR = ("kind", "f", "L")  # by tables of kinds, and by rules between keys
ODD_NUMBERS = (0, -1, -0.0, 5e-324, 1e-300, 1.7e308, -1.7e308, math.inf, -math.inf, math.nan, 2**63, 10**400)
ODD = st.one_of(
    st.sampled_from(ODD_NUMBERS), st.booleans(), st.text(max_size=8), st.dates(), st.builds(list), st.builds(dict),
    st.lists(st.sampled_from(ODD_NUMBERS), max_size=4), st.dictionaries(st.text(max_size=4), st.integers(), max_size=2),
)  # fmt: skip


# From models to strategies


def in_order(values: list) -> list:
    """Sorted, where they have an order: odd values have none."""
    try:
        return sorted(values)
    except TypeError:
        return values


@cache
def sections(model: type[Section]) -> st.SearchStrategy[dict[str, Any]]:
    """Tables with all required keys of `model`, and some of the others."""
    keys = {key: of(field.annotation, field.metadata, key) for key, field in model.model_fields.items()}
    required = {key for key, field in model.model_fields.items() if field.is_required() or key in ASKED_FOR}
    return st.fixed_dictionaries(
        {key: value for key, value in keys.items() if key in required},
        optional={key: value for key, value in keys.items() if key not in required},
    )


def of(annotation: Any, metadata: Any, key: str) -> st.SearchStrategy[Any]:
    """Values of a type, within the bounds that its metadata set, for `key`."""
    for marker in metadata:
        if isinstance(marker, Chosen):
            return st.one_of(*(sections(model) for model in marker.models.values()))
        if isinstance(marker, Named):
            return st.sampled_from(marker.names)
    origin, parts = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return of(parts[0], [*metadata, *annotation.__metadata__], key)
    if origin in (Union, UnionType):
        return st.one_of(*(of(part, metadata, key) for part in parts if part is not type(None)))
    if origin is Literal:
        return st.sampled_from(parts)
    if origin is tuple:
        if Ellipsis not in parts:
            return st.tuples(*(of(part, [], key) for part in parts))
        items = of(parts[0], [], key)
        if isinstance(parts[0], type) and issubclass(parts[0], Section):
            return st.lists(items, max_size=3)
        return st.lists(items, min_size=1, max_size=3, unique_by=repr).map(in_order)
    if isinstance(annotation, type) and issubclass(annotation, Section):
        return sections(annotation)
    return PLAIN[annotation](bounds(metadata), key) if annotation in PLAIN else ODD


def bounds(metadata: Any) -> dict[str, float]:
    """The bounds gt, ge, lt, le among metadata, nested or not."""
    found: dict[str, float] = {}
    for marker in metadata:
        found |= bounds(getattr(marker, "metadata", ()))
        found |= {name: getattr(marker, name) for name in ("gt", "ge", "lt", "le") if hasattr(marker, name)}
    return found


PACKING = {"lt": 1.0}  # of all closures of the package, which says what area fractions are allowed


def numbers(bound: dict[str, float], key: str) -> st.SearchStrategy[float]:
    """Numbers within the bounds: of ordinary size, and of any that decks allow."""
    bound = bound | PACKING if key == "f" else bound
    low, high = bound.get("gt", bound.get("ge", -LARGEST)), bound.get("lt", bound.get("le", LARGEST))
    strict = [end for name, end in bound.items() if name in ("gt", "lt")]
    sizes = [sign * 10.0**power for sign in (1.0, -1.0) for power in range(-30, 31)]
    inside = [size for size in (*sizes, 0.0, low, high) if low <= size <= high and size not in strict]
    grain = max(low, -8.0), min(high, 8.0)
    ordinary = st.integers(1, 999).map(lambda k: grain[0] + (grain[1] - grain[0]) * k / 1000.0)
    return st.one_of(ordinary, ordinary, st.sampled_from(inside))


def whole_numbers(bound: dict[str, float], key: str) -> st.SearchStrategy[int]:
    """Whole numbers that the bounds allow, small where large ones cost memory."""
    low = int(bound.get("ge", -20))
    return st.integers(low, min(int(bound.get("le", 20)), SMALL.get(key, 2**63)))


PLAIN = {
    float: numbers,
    int: whole_numbers,
    bool: lambda bound, key: st.booleans(),
    str: lambda bound, key: st.text(max_size=8),
}


def places(model: type[Section], above: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], st.SearchStrategy]]:
    """The way to every key of `model` and of its sections, with values for it."""
    for key, field in model.model_fields.items():
        yield (*above, key), of(field.annotation, field.metadata, key)
        choice = choice_of(model, key)
        chosen = () if choice is None else choice.models.values()
        inside = [section_of(model, key), item_of(model, key), list_or(model, key), *chosen]
        for inner in inside:
            yield from places(inner, (*above, key)) if inner else ()


STUDIES = ("convergence", "sweep")  # hardly ever right by chance, so drawn less often
MODELS: dict[str, Any] = {kind: KINDS.section(kind) for kind in KINDS}
DRAWN = [kind for kind in sorted(KINDS) for _ in range(1 if kind in STUDIES else 3)]
PLACES = {kind: dict(places(model)) for kind, model in MODELS.items()}
ANYWHERE = st.sampled_from(sorted({place for known in PLACES.values() for place in known}))
NONSENSE = st.lists(st.text(min_size=1, max_size=5), min_size=1, max_size=3).map(tuple)
WHERE = {kind: st.one_of(st.sampled_from(sorted(known)), ANYWHERE, NONSENSE) for kind, known in PLACES.items()}


@st.composite
def decks(draw) -> dict[str, Any]:
    """A deck of any kind; some have values or keys put in, or taken out, without regard to what is allowed."""
    kind = draw(st.sampled_from(DRAWN))
    deck = draw(sections(MODELS[kind]))
    if draw(st.integers(0, 3)):
        deck.pop("experiment", None)  # a random one is hardly ever right
    for _ in range(draw(st.sampled_from((0, 0, 0, 1, 2)))):
        *above, last = draw(WHERE[kind])
        section: Any = deck
        for key in above:
            section = section.setdefault(key, {}) if isinstance(section, dict) else {}
        if isinstance(section, dict):
            section[last] = draw(ODD)
            if draw(st.booleans()):
                del section[last]
    return deck


# From values to text


def toml(value: Any) -> str:
    """A value as TOML."""
    if isinstance(value, dict):
        return f"{{{', '.join(f'{toml(key)} = {toml(inner)}' for key, inner in value.items())}}}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(toml, value))}]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return value.isoformat() if isinstance(value, date) else json.dumps(value).replace("Infinity", "inf").lower()


TOP = {key for model in MODELS.values() for key in model.model_fields}


def escaped(text: str) -> str:
    """With what cannot be printed as an escape."""
    return "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in text)


def refused_by_name(code: int, message: str, keys: Any) -> bool:
    """Whether a deck was refused with a complaint about one of `keys`, or of those that decks have, or a member has."""
    starts = tuple(f"  {shown}" for key in {*keys, *TOP} for shown in (key, ascii(key), escaped(key)))
    member = re.compile(r": .*, in member \d+: .* = ")
    return code == 2 and any(line.startswith(starts) or member.search(line) for line in message.splitlines())


def test_generated_decks(tmp_path, capsys):
    path, codes = tmp_path / "deck.toml", collections.Counter()

    @AT_RANDOM
    @given(decks())
    def check(deck):
        path.write_text("\n".join(f"{toml(key)} = {toml(value)}" for key, value in deck.items()), encoding="utf-8")
        code, message = main(["check", str(path)]), capsys.readouterr().err
        codes[code] += 1
        assert code == 0 or refused_by_name(code, message, deck), message

    check()
    assert codes.total() == 2000 and codes[0] > 400 and codes[2] > 400


BASES = {path: tomllib.loads(path.read_text(encoding="utf-8"))["kind"] for path in sorted(PROBLEMS.glob("*.toml"))}


@st.composite
def overrides(draw) -> tuple[str, str]:
    """A deck of the repository, and an override for it: mostly of a key that it knows, by a value of the right type."""
    deck, kind = draw(st.sampled_from(sorted(BASES.items())))
    known = PLACES[kind]
    if draw(st.integers(0, 2)):
        keys = draw(st.sampled_from(sorted(known)))
        return str(deck), f"{'.'.join(keys)}={toml(draw(known[keys]))}"
    odd = st.builds(lambda keys, value: f"{'.'.join(keys)}={toml(value)}", WHERE[kind], ODD)
    return str(deck), draw(st.one_of(odd, st.text(st.characters(exclude_categories=[]), max_size=12)))


def test_random_overrides(capsys):
    codes = collections.Counter()

    @AT_RANDOM
    @given(overrides())
    def check(deck_and_override):
        deck, override = deck_and_override
        try:
            code = main(["check", deck, override])
        except SystemExit as ended:  # what looks like an option is refused with the usage, by the argument parser
            assert override.startswith("-")
            codes[ended.code] += 1
            return
        message, key = capsys.readouterr().err, override.partition("=")[0]
        codes[code] += 1
        assert code == 0 or refused_by_name(code, message, [key, key.partition(".")[0].strip()]), message

    check()
    assert codes.total() == 2000 and codes[0] > 400 and codes[2] > 400
