"""The rooms of the house: imports go from a later room to an earlier one, and nowhere in circles."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import hydro

PACKAGE = Path(hydro.__file__).parent
ARCHITECTURE = PACKAGE.parent / "docs" / "architecture.md"

COLUMN = 62  # of the drawing, from which on the lines are words
DRAWING = ARCHITECTURE.read_text(encoding="utf-8").split("```")[1].splitlines()
ROOMS = [name for line in reversed(DRAWING) for name in line[:COLUMN].replace("|", " ").split()]


def name_of(path: Path) -> str:
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {name_of(path): path for path in PACKAGE.rglob("*.py")}


def room(module: str) -> str:
    return module.split(".")[1]


def imports(tree: ast.AST, at_once: bool) -> Iterator[str]:
    """Modules of the package that a source imports: all, or only those at once, when it is imported itself."""
    for node in ast.walk(tree):
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            node.body = []
    body = tree.body if at_once and isinstance(tree, ast.Module) else list(ast.walk(tree))
    for node in body:
        if isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] == "hydro":
            for alias in node.names:
                longer = f"{node.module}.{alias.name}"
                yield longer if longer in MODULES else node.module


def arrows(at_once: bool) -> dict[str, set[str]]:
    trees = {module: ast.parse(path.read_text(encoding="utf-8")) for module, path in MODULES.items()}
    return {module: set(imports(tree, at_once)) - {module, "hydro"} for module, tree in trees.items()}


def test_every_room_is_drawn_once():
    assert sorted(ROOMS) == sorted({room(module) for module in MODULES if module != "hydro"} - {"__main__"})


def test_imports_go_down_the_drawing_and_to_the_left():
    """Those inside functions count too: they save time at the start, not order."""
    place = {name: number for number, name in enumerate([*ROOMS, "__main__"])}
    wrong = [
        f"{module} -> {used}"
        for module, uses in arrows(at_once=False).items()
        for used in uses
        if module != "hydro" and place[room(used)] > place[room(module)]
    ]
    assert not wrong


def test_no_modules_import_each_other_in_a_circle():
    try:
        TopologicalSorter(arrows(at_once=True)).prepare()
    except CycleError as circle:
        raise AssertionError(" -> ".join(circle.args[1])) from None


def test_the_walks_name_what_is_there():
    """Every `file:name` of the page; files of one folder are named in short after the first."""
    for path, name in re.findall(r"`([\w/]+\.py):([\w.]+)`", ARCHITECTURE.read_text(encoding="utf-8")):
        places = [PACKAGE.parent / path] if path.startswith("hydro/") else list(PACKAGE.rglob(path))
        last = name.rpartition(".")[2]
        text = "".join(place.read_text(encoding="utf-8") for place in places)
        assert re.search(rf"^ *(def|class) {last}\b|^{last}\b.* = ", text, re.MULTILINE), (path, name)
