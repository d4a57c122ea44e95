"""What the documentation shows works as it is shown."""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from hydro import choices
from hydro.cli import COMMANDS
from hydro.deck import load, parse
from hydro.deck.reference import reference
from hydro.registry import Registry

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


EXTENDING = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")


def write_extensions(folder: Path, package: Path = ROOT) -> None:
    """Write the files of docs/extending.md into a folder, those of the package into a copy of it."""
    for language in ("python", "toml"):
        for text in blocks(language, EXTENDING):
            name = text.partition("\n")[0].removeprefix("# ")
            path = (package if name.startswith("hydro/") else folder) / name
            if package != ROOT or path.parent == folder:
                path.write_text(text, encoding="utf-8")


def extension(folder: Path, deck: str, *words: str, package: Path = ROOT) -> dict:
    """The summary of a deck of docs/extending.md, run in a folder that has all its files."""
    write_extensions(folder, package)
    done = subprocess.run(
        [sys.executable, "-m", "hydro", deck, *words, "--output", "run", "--overwrite", "--quiet"],
        cwd=folder, env=os.environ | {"PYTHONPATH": str(package)}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert f"    python -m hydro {deck}\n" in EXTENDING
    return json.loads((folder / "run" / "summary.json").read_text())


def test_a_closure_of_ones_own_runs(tmp_path):
    dense, dilute = (extension(tmp_path, "dilute.toml", *words) for words in (["gas.closure=grossman"], []))
    assert dense["wall_max"] == pytest.approx(dilute["wall_max"], rel=0.1)  # close in a dilute gas
    assert dense["wall_max"] != dilute["wall_max"]


def test_a_wall_an_initial_state_and_an_integrator_of_ones_own_run(tmp_path):
    ledger = extension(tmp_path, "heated.toml")["energy_ledger"]
    assert ledger["wall"] == pytest.approx(0.01 * 0.25 * 0.2, rel=1e-12) and ledger["collisions"] == 0.0


def test_a_wall_of_ones_own_stands_on_any_side(tmp_path):
    write_extensions(tmp_path)
    done = subprocess.run(
        [sys.executable, "walls_on_two_sides.py"], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    temperature, given = map(float, done.stdout.split())
    assert temperature > 1.5 and 0.0 < given < 0.01  # most of what one wall gives stays in the gas


@pytest.fixture
def package(tmp_path):
    """A copy of the package with the lines that the page shows for the tables of these names."""

    def with_lines(*tables: str) -> Path:
        copy = tmp_path / "copy"
        shutil.copytree(ROOT / "hydro", copy / "hydro", ignore=shutil.ignore_patterns("__pycache__"))
        choices = copy / "hydro" / "choices.py"
        text = choices.read_text(encoding="utf-8")
        for table in tables:
            (line,) = re.findall(rf"`{table}`: `([^`]+)`", EXTENDING)
            text, count = re.subn(rf"^({table}: .*?\{{)(.*?)\}}", rf"\1\2, {line}}}", text, flags=re.M | re.S)
            assert count == 1
        choices.write_text(text.replace(",\n    , ", ",\n        "), encoding="utf-8")
        return copy

    return with_lines


def test_a_kind_of_deck_is_a_file_and_a_line(tmp_path, package):
    slow, fast = extension(tmp_path, "sound.toml", package=package("KINDS"))["speeds"]
    assert fast / slow == pytest.approx(2.0**0.5, rel=1e-12)


def test_a_term_and_a_set_of_observables_are_a_file_and_a_line_each(tmp_path, package):
    summary = extension(tmp_path, "tide.toml", package=package("TERMS", "OBSERVABLES"))
    ledger, (last,) = summary["energy_ledger"], summary["snapshots"]
    assert ledger["tide"] > 0.0 and ledger["tide"] == pytest.approx(ledger["change"], rel=1e-10)
    assert last["mean_temperature"] == pytest.approx(1.0, rel=0.05) and "wall_max" not in last


def test_the_lines_of_the_page_name_the_files_of_the_page():
    """Each row of its table: the file, and the line that leads to it."""
    rows = re.findall(r"\| `(hydro/\S+)\.py`.* `([A-Z_]+)`: `\"(\w+)\": (?:Entry\()?\"([\w.]+):(\w+)", EXTENDING)
    assert len(rows) == 7 and all(file.replace("/", ".") == module for file, _, _, module, _ in rows)
    assert all(isinstance(getattr(choices, table), Registry) for _, table, _, _, _ in rows)


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
