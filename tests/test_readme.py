"""What the documentation shows works as it is shown."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from hydro.deck import parse
from hydro.deck.reference import reference

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    """Code blocks of the README in a language."""
    return re.findall(rf"```{language}\n(.*?)```", README, flags=re.DOTALL)


def test_the_deck_is_valid():
    (deck,) = blocks("toml")
    assert parse(deck).mesh.cells == (64, 128)


def test_the_program_runs(capsys):
    (program,) = blocks("python")
    exec(compile(program.replace("< 10.0", "< 0.1"), "README.md", "exec"), {})
    assert 0.02 < float(capsys.readouterr().out) < 0.03


@pytest.mark.parametrize(
    "page", [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))], ids=lambda page: page.name
)
def test_links_lead_somewhere(page):
    links = re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8"))
    files = [page.parent / link for link in links if "://" not in link]
    assert not [file for file in files if not file.exists() or file.stat().st_size == 0]


def test_the_page_of_deck_keys_is_up_to_date():
    assert (ROOT / "docs" / "decks.md").read_text(encoding="utf-8").strip() == reference().strip()
