"""Tables of what decks may name: everything is there, and loaded only when it is used."""

from __future__ import annotations

import subprocess
import sys

import pytest

from hydro import choices
from hydro.registry import Entry, Registry, UnknownName

TABLES = {name: table for name, table in vars(choices).items() if isinstance(table, Registry)}


@pytest.mark.parametrize(("name", "key"), [(name, key) for name, table in TABLES.items() for key in table])
def test_every_name_stands_for_something(name, key):
    assert TABLES[name][key] is not None and TABLES[name].section(key) is not None


def test_an_unknown_name_is_told_the_nearest():
    registry = Registry("limit", {"square root": "math:sqrt", "both": Entry("math:sqrt", section="math:pi")})
    assert registry["square root"](4.0) == 2.0 and registry.section("both") == pytest.approx(3.14, abs=0.01)
    with pytest.raises(UnknownName, match=r"unknown limit 'square rot'; known: .*; did you mean 'square root'"):
        registry["square rot"]
    assert "square rot" not in registry and len(registry) == 2


def test_the_names_are_known_without_what_they_stand_for():
    code = "import sys, hydro.choices; print(*[name for name in sys.modules if name.startswith('hydro')])"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert set(done.stdout.split()) == {"hydro", "hydro.choices", "hydro.methods", "hydro.own", "hydro.registry"}
