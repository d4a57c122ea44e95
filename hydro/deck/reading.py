"""From deck files, base decks and overrides to a valid deck."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from hydro.deck.complaints import printable
from hydro.deck.overrides import DECKS, Keys, override, put_all
from hydro.deck.sections import Deck
from hydro.deck.validation import validate
from hydro.errors import Complaint, DeckError
from hydro.own import anchored, is_own
from hydro.schema import Chosen, choice_of


def load(path: str | Path, overrides: Iterable[str] = ()) -> Deck:
    """The deck in the TOML file `path`, changed by overrides `section.key=value`.

    Raises DeckError, with every complaint at once, when anything is wrong with file, overrides or deck.
    """
    source = printable(str(path))
    return parse(_read(Path(path), source), overrides, source, Path(path).parent)


def parse(text: str, overrides: Iterable[str] = (), source: str = "deck", folder: Path | None = None) -> Deck:
    """As `load`, from TOML text; `source` names the deck in messages.

    Base decks and files of a user's own are looked for in `folder`.
    """
    beside = folder or Path()
    data = _anchored(_data(text, source), beside)
    complaints = [*_include(data, DECKS, beside), *override(data, overrides)]
    return validate(_anchored(data, beside), source, complaints)


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


def _include(data: dict[str, Any], choice: Chosen, folder: Path) -> list[Complaint]:
    """Put the files that `base` names in its place; what is wrong with the keys that change them comes back."""
    model, base = choice.model_in(data), data.get("base")
    name = base.get("deck") if isinstance(base, dict) else base
    inside = None if model is None else choice_of(model, "base")
    if inside is None or not isinstance(name, str):
        return []
    path = folder / name
    source = f"base {printable(str(path))}"
    inner = _anchored(_data(_read(path, source), source), path.parent)
    complaints = _include(inner, inside, path.parent)
    if isinstance(base, dict):
        complaints += put_all(inner, [(keys, value) for keys, value in _settings(base) if keys != ("deck",)])
    data["base"] = inner
    return complaints


def _settings(table: Mapping[str, Any], above: Keys = ()) -> Iterator[tuple[Keys, Any]]:
    """All values in nested tables with the ways to them."""
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _settings(value, (*above, key))
        else:
            yield (*above, key), value


# Files of a user's own


def _anchored(data: dict[str, Any], folder: Path) -> dict[str, Any]:
    """A deck in which parts of a user's own, `file.py:Class`, have the whole path of their file."""
    return {key: value if key == "about" else _with_paths(value, folder) for key, value in data.items()}


def _with_paths(value: Any, folder: Path) -> Any:
    if isinstance(value, dict):
        return {key: _with_paths(inner, folder) for key, inner in value.items()}
    if isinstance(value, list):
        return [_with_paths(inner, folder) for inner in value]
    return anchored(value, folder) if is_own(value) else value
