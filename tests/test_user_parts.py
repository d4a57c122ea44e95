"""Closures, walls and initial states of a user's own, which decks name as `file.py:Class`."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import restart, summary_of

import hydro
from hydro.cli import main
from hydro.deck import changed, dumps, load, parse
from hydro.errors import DeckError
from hydro.gas import Grossman
from hydro.own import own_module
from hydro.setup import gas_of, integrator_of, wall_of

GAS = """
from typing import Annotated, NamedTuple

from hydro.gas import Grossman, HardDisks
from hydro.methods import compiled_methods
from hydro.schema import Positive

LAWS = {name: law for name, law in vars(Grossman).items() if callable(law) and not name.startswith("_")}


class Constants(NamedTuple):
    L: float
    K: float
    alpha: float
    lossy: Positive = 1.0
    steps: int = 1


@compiled_methods
class Lossy(Constants, type("Laws", (HardDisks,), LAWS)):
    "Loses more energy in collisions."

    __slots__ = ()

    def cooling_factor(self, n):
        return self.lossy * 0.5 * n * n * self.K * self.L

    def cooling_factor_slope(self, n):
        return self.lossy * n * self.K * self.L
"""
WALL = """
from typing import NamedTuple

from hydro.methods import compiled_methods


@compiled_methods
class GivenFlux(NamedTuple):
    flux: float = 0.25

    def face(self, gas, n, T, half_width, guess):
        return self.flux, T

    def face_slopes(self, gas, n, T, half_width, wall):
        return 0.0, 0.0
"""
STATE = """
import numpy as np

from hydro.initial.state import InitialState
from hydro.schema import Positive
from hydro.state import State


class Blob(InitialState):
    "A dense place in the middle."

    width: Positive = 0.1

    def state(self, deck, gas, mesh):
        x, y = mesh.x[:, None] - 0.5, mesh.y[None, :] - 0.5 * mesh.aspect_ratio
        return State.of(gas, mesh, 0.02 + 0.05 * np.exp(-(x * x + y * y) / self.width), 1.0)
"""
DECK = """
kind = "evolution"
gas = { closure = "my_gas.py:Lossy", L = 1e3, f = 0.05, K = 1e-2, alpha = 1.15, lossy = 2.0 }
mesh = { cells = [8, 8] }
initial = { kind = "cosine" }
time = { end = 0.02 }
"""


@pytest.fixture
def beside(tmp_path):
    """A folder with parts of a user's own and a deck that names one; old, so that kernels for them are kept."""
    for name, text in (("my_gas.py", GAS), ("my_wall.py", WALL), ("my_state.py", STATE), ("deck.toml", DECK)):
        (tmp_path / name).write_text(text)
        os.utime(tmp_path / name, (1e9, 1e9))
    return tmp_path


def refused(folder: Path, *overrides: str) -> dict[str, str]:
    """The complaints about the deck in a folder, by key."""
    with pytest.raises(DeckError) as caught:
        load(folder / "deck.toml", overrides)
    return {complaint.key: str(complaint) for complaint in caught.value.complaints}


def test_the_fields_of_a_closure_are_keys_of_its_gas(beside):
    deck = load(beside / "deck.toml")
    gas = gas_of(deck)
    assert type(gas).__name__ == "Lossy" and gas == (1e3, 1e-2, 1.15, 2.0, 1) and gas_of(deck, L=3.0).L == 3.0
    assert gas.compressibility(0.3) == Grossman(1e3, 1e-2).compressibility(0.3)
    assert (
        load(beside / "deck.toml", ["gas.closure=grossman"]).gas.alpha == 1.15
    )  # what only the other knows is dropped
    assert "lossy" not in dumps(load(beside / "deck.toml", ["gas.closure=grossman"]))
    assert f'closure = "{beside}/my_gas.py:Lossy"' in dumps(deck) and parse(dumps(deck)) == deck


@pytest.mark.parametrize(
    ("override", "key", "problem"),
    [
        ("gas.closure=nowhere.py:Lossy", "gas.closure", "nowhere.py cannot be read: No such file or directory"),
        ("gas.closure=my_gas.py:Losy", "gas.closure", "my_gas.py has no class Losy; it has Constants, Lossy"),
        ("gas.closure=my_gas.py:LAWS", "gas.closure", "has no class LAWS"),
        ("gas.closure=my_gas.py:Positive", "gas.closure", "has no class Positive"),
        ("gas.closure=my_wall.py:GivenFlux", "gas.closure", "GivenFlux lacks packing_density, pressure_factor"),
        ("gas.closure=my_state.py:Blob", "gas.closure", "Blob must be a NamedTuple of its constants"),
        ("gas.closure=my_gas.py:Constants", "gas.closure", "Constants must stand under the decorator"),
        ("gas.closure=my_gas.py", "gas.closure", "'my_gas.py' is not known; known: grossman"),
        ("wall.kind=my_gas.py:Lossy", "wall.kind", "Lossy lacks face, face_slopes: see hydro.walls.law.WallLaw"),
        ("initial.kind=my_wall.py:GivenFlux", "initial.kind", "must derive from hydro.initial.state.InitialState"),
        (
            "gas.lossi=1",
            "gas.lossi",
            "unknown key; known: L, f, K, tau, gamma, mu, closure, viscosity, elastic_below, alpha, lossy",
        ),
        ("gas.lossy=-1", "gas.lossy", "must be greater than 0"),
        ("gas.alpha=x", "gas.alpha", "'x' is not allowed; must be a number"),
        ("gas.steps=0.5", "gas.steps", "must be a whole number"),
        ("gas={closure='my_gas.py:Lossy', L=1, K=1, f=0.1}", "gas.alpha", "required"),
        ("wall={kind='my_wall.py:GivenFlux', flux=1, W=2}", "wall.W", "unknown key; known: kind, flux"),
        ("initial={kind='my_state.py:Blob', width=0}", "initial.width", "must be greater than 0"),
    ],
)
def test_what_is_wrong_with_a_part_is_said_by_key(beside, override, key, problem):
    found = refused(beside, override)
    assert list(found) == [key] and problem in found[key]


@pytest.mark.parametrize(
    ("before", "after", "problem"),
    [
        ("class Constants", "class (", "cannot be run: SyntaxError: invalid syntax (line 11)"),
        ("import Grossman, ", "import Grosman, ", "cannot be run: ImportError: cannot import name 'Grosman'"),
        ("LAWS = {", "raise SystemExit('no')\nLAWS = {", "cannot be run: SystemExit: no (line 8)"),
        ("steps: int", "count: int", "the field count of Lossy needs another name"),
        ("steps: int = 1", "steps: list.sort = 1", "the fields of Lossy must be of type float, int or bool"),
        ("L: float", "L: flaot", "cannot be run: NameError"),
    ],
)
def test_a_file_that_is_no_good_is_refused(beside, before, after, problem, capsys):
    (beside / "my_gas.py").write_text(GAS.replace(before, after).replace("count", "model_fields"))
    assert main(["check", str(beside / "deck.toml")]) == 2
    said = capsys.readouterr().err
    assert "gas.closure: " in said and problem.replace("count", "model_fields") in said and "Traceback" not in said


def test_a_run_with_a_closure_of_ones_own_does_all_that_runs_do(beside, tmp_path_factory, monkeypatch):
    """It runs, is read, filmed, reported and gone on with, from wherever, to the same bits as in one go."""
    monkeypatch.chdir(tmp_path_factory.mktemp("elsewhere"))
    words = [str(beside / "deck.toml"), "output.movie=true", "output.movie_every=0.01", "movie.gif=false", "--quiet"]
    whole, halves = beside / "whole", beside / "halves"
    assert main([*words, "--output", str(whole)]) == 0
    assert main([*words, "time.end=0.01", "--output", str(halves)]) == 0 and restart(halves, "time.end=0.02") == 0
    states = [hydro.open_run(folder).isel(time=-1) for folder in (whole, halves)]
    assert float(states[0].time) == 0.02 and (whole / "movie.mp4").exists()
    np.testing.assert_allclose(states[0].density, states[1].density, rtol=1e-3)
    assert main(["movie", str(halves), "--quiet"]) == 0 and main(["report", str(halves), "--quiet"]) == 0
    assert "my_gas.py:Lossy" in (halves / "report.html").read_text()
    grossman = beside / "grossman"
    assert main([*words[:1], "gas.closure=grossman", "--quiet", "--output", str(grossman)]) == 0
    lost = [summary_of(folder)["energy_ledger"]["collisions"] for folder in (whole, grossman)]
    assert lost[0] != pytest.approx(lost[1], rel=0.1)


def test_a_wall_and_a_state_of_ones_own(beside):
    words = ["wall={kind='my_wall.py:GivenFlux', flux=0.5}", "initial={kind='my_state.py:Blob', width=0.02}"]
    deck = load(beside / "deck.toml", ["gas.closure=grossman", *words])
    assert wall_of(deck) == (0.5,) and parse(dumps(deck)) == deck
    state = deck.initial.state(deck, gas_of(deck), hydro.setup.mesh_of(deck))
    assert integrator_of(deck, state).step(state, 1e-3)["wall"] == pytest.approx(0.5e-3, rel=1e-12)
    assert "flux" not in dumps(changed(deck, {"wall.kind": "thermal"}))


def test_members_of_a_sweep_find_the_file(beside, tmp_path_factory):
    """Paths are those of the study's folder, or of its base deck's; a worker elsewhere needs nothing but the deck."""
    (beside / "inner").mkdir()
    (beside / "deck.toml").rename(beside / "inner" / "base.toml")
    (beside / "my_wall.py").rename(beside / "inner" / "my_wall.py")
    base = "{deck = 'inner/base.toml', gas = {closure = 'my_gas.py:Lossy'}, wall = {kind = 'thermal'}}"
    axes = "[{keys = ['gas.closure'], values = ['my_gas.py:Lossy', 'grossman']}]"
    (beside / "sweep.toml").write_text(f"kind = 'sweep'\nbase = {base}\nsweep = {{axes = {axes}}}\n")
    study = load(beside / "sweep.toml")
    members = [changed(study.base, changes) for changes in study.changes]
    assert [gas_of(member)._fields[-1] for member in members] == ["steps", "alpha"]
    code = "import sys; from hydro.deck import parse; print(parse(sys.stdin.read()).gas.law())"
    done = subprocess.run(
        [sys.executable, "-c", code], input=dumps(members[0]), cwd=tmp_path_factory.mktemp("worker"),
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stdout.startswith("Lossy(L=1000.0")


def test_a_module_is_named_after_its_content(beside):
    first = own_module(beside / "my_wall.py")
    assert sys.modules[first.__name__] is first and own_module(beside / "my_wall.py") is first
    (beside / "my_wall.py").write_text(WALL.replace("0.25", "0.75"))
    assert own_module(beside / "my_wall.py").GivenFlux() == (0.75,) and first.GivenFlux() == (0.25,)


def test_notes_are_left_alone(beside):
    assert load(beside / "deck.toml", ["about.notes=my_gas.py:Lossy"]).about.notes == "my_gas.py:Lossy"
