"""What pages print is what their commands compute."""

from __future__ import annotations

import re
import shlex
from itertools import pairwise
from pathlib import Path

import pytest
from pages import COMPUTED, NOT_RERUN

from hydro.cli import main

ROOT = Path(__file__).parent.parent
PAGES = {page.name: page.read_text(encoding="utf-8") for page in [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]}
MARK = re.compile(r"^<!-- (computed|printed): (.+?) -->\n(.*?)(?=\n\n|\Z)", flags=re.MULTILINE | re.DOTALL)
MARKS = [(page, *mark) for page, text in sorted(PAGES.items()) for mark in MARK.findall(text)]
BLOCK = re.compile(r"^<!-- printed: (.+?) -->\n+```\w*\n(.*?)```", flags=re.MULTILINE | re.DOTALL)
BLOCKS = [(page, *block) for page, text in sorted(PAGES.items()) for block in BLOCK.findall(text)]


@pytest.mark.parametrize(
    ("page", "name", "marked"),
    [pytest.param(page, name, text, id=f"{page}-{name}") for page, kind, name, text in MARKS if kind == "computed"],
)
def test_numbers_that_are_marked_are_those_computed(page, name, marked):
    said = " ".join(marked.split())
    missing = [text for text in COMPUTED[name]() if " ".join(text.split()) not in said]
    assert not missing, f"{page} says:\n{marked}"


@pytest.mark.parametrize(
    ("page", "command", "block"), [pytest.param(*entry, id=f"{entry[0]}-{entry[1]}") for entry in BLOCKS]
)
def test_blocks_that_are_marked_are_what_the_command_prints(page, command, block, tmp_path, monkeypatch, capsys):
    """Line by line; `...` stands for lines that the page leaves out."""
    (tmp_path / "problems").symlink_to(ROOT / "problems")
    monkeypatch.chdir(tmp_path)
    assert main(shlex.split(command)[3:]) == 0
    printed, place = capsys.readouterr().out, 0
    block = block.replace("\n#   ", " ")  # lines that the page has broken
    for part in re.split(r"^\.\.\.\n", block, flags=re.MULTILINE):
        assert part.strip() in printed[place:], f"{page}: {command}"
        place = printed.index(part.strip(), place) + len(part.strip())


def test_every_mark_is_known_and_every_computation_is_marked():
    named = [name for _, kind, name, _ in MARKS if kind == "computed"]
    assert set(named) == set(COMPUTED)
    assert len(BLOCKS) == sum(kind == "printed" for _, kind, _, _ in MARKS) >= 1


def test_every_page_is_marked_or_says_why_not():
    """One or the other."""
    marked = {page for page, *_ in MARKS}
    assert marked | NOT_RERUN.keys() | {"README.md"} == PAGES.keys()
    assert not marked & NOT_RERUN.keys()


def test_a_number_that_has_changed_is_noticed(monkeypatch):
    """The test above fails where one digit of the page is not that computed."""
    page, name, marked = next((page, name, text) for page, kind, name, text in MARKS if name == "ratios_of_viscosities")
    for digit, other in pairwise("0123456789"):
        changed = marked.replace(f"0.{digit}", f"0.{other}", 1)
        if changed != marked:
            with pytest.raises(AssertionError):
                test_numbers_that_are_marked_are_those_computed(page, name, changed)
            return
    raise AssertionError("the page has no number to change")
