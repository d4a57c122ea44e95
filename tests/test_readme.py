"""What the documentation shows works as it is shown."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from hydro.cli import COMMANDS
from hydro.deck import load, parse
from hydro.deck.reference import reference

ROOT = Path(__file__).parent.parent
BENCHMARKS = ROOT / "benchmarks"
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language: str, text: str = README) -> list[str]:
    """Code blocks of the README, or of another text, in a language."""
    return re.findall(rf"```{language}\n(.*?)```", text, flags=re.DOTALL)


def test_the_deck_is_valid():
    (deck,) = blocks("toml")
    assert parse(deck).mesh.cells == (64, 128)


def printed_by(program: str, capsys) -> list[float]:
    """The numbers that a program prints."""
    exec(compile(program, "README.md", "exec"), {})
    return [float(word) for word in capsys.readouterr().out.split()]


def test_the_programs_run(capsys):
    steady, evolution = blocks("python")
    densest, rate = printed_by(steady, capsys)
    assert densest == pytest.approx(0.679, abs=0.005) and rate == pytest.approx(1.09e-3, rel=0.01)
    densest, residual = printed_by(evolution.replace("until=10.0", "until=0.1"), capsys)
    assert 0.02 < densest < 0.03 and abs(residual) < 1e-10


def test_the_extensions_run(tmp_path):
    """The scripts of docs/extending.md: kernels take code from files only."""
    numbers = []
    for name, program in enumerate(blocks("python", (ROOT / "docs" / "extending.md").read_text(encoding="utf-8"))):
        script = tmp_path / f"extension_{name}.py"
        script.write_text(program, encoding="utf-8")
        done = subprocess.run([sys.executable, script], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        numbers.append(re.findall(r"[\d.e-]+$", done.stdout, flags=re.MULTILINE))
    (dense, dilute), (given,), (code,), _ = numbers
    assert float(dense) == pytest.approx(float(dilute), rel=0.1) and dense != dilute  # close in a dilute gas
    assert float(given) == pytest.approx(1.0, rel=1e-10)
    assert code == "0" and (tmp_path / "output" / "blob" / "summary.json").exists()


def test_the_commands_name_decks_and_their_keys():
    """Every command line that runs or checks a deck, but for checkpoints that are not there yet."""
    text = README.replace("\\\n", " ")
    lines = re.findall(r"^    (?:.*&& )?\S*python -m hydro (.*)$", text, flags=re.MULTILINE)
    lines = [words for words in map(shlex.split, lines) if words[0] not in COMMANDS.keys() - {"check"}]
    assert len(lines) >= 5
    for words in lines:
        output = words.index("--output") if "--output" in words else len(words)
        deck, *overrides = [word for word in words[:output] if word != "check"]
        load(ROOT / deck, overrides)


def test_the_pictures_are_there():
    pictures = re.findall(r'<img src="([^"]+)"', README)
    assert len(pictures) == 8 and all((ROOT / picture).stat().st_size > 0 for picture in pictures)


def test_every_deck_is_in_the_table():
    named = set(re.findall(r"`(?:problems/)?(\w+)\.toml`", README)) | {"fig3b", "fig3c"}
    assert {deck.stem for deck in (ROOT / "problems").glob("*.toml")} <= named


@pytest.mark.parametrize(
    "page", [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))], ids=lambda page: page.name
)
def test_links_lead_somewhere(page):
    links = re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8"))
    files = [page.parent / link for link in links if "://" not in link]
    assert not [file for file in files if not file.exists() or file.stat().st_size == 0]


def test_the_page_of_deck_keys_is_up_to_date():
    assert (ROOT / "docs" / "decks.md").read_text(encoding="utf-8").strip() == reference().strip()


@pytest.mark.parametrize(("folder", "pattern"), [(BENCHMARKS, "*.py"), (BENCHMARKS / "papers", "**/*.py")])
def test_the_benchmarks_find_what_they_import(folder, pattern):
    """All but the program that pyro2's own environment runs."""
    modules = [path for path in folder.glob(pattern) if path.stem not in ("pyro_worker", "__init__")]
    names = [".".join(path.relative_to(folder).with_suffix("").parts) for path in modules]
    assert len(names) > 10
    program = "\n".join(f"import {name}" for name in names)
    done = subprocess.run([sys.executable, "-c", program], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
