"""Decks run from Python."""

from __future__ import annotations

import json
import tomllib

import pytest
from conftest import PROBLEMS

import hydro
from hydro.deck import load
from hydro.errors import DeckError

SMALL = ("mesh.cells=[8,4]", "time.end=0.02", "output.times=[0.01,0.02]", "output.pictures=false")
CURVES = """
kind = "stability"
stability = { L = [5e4], f = [0.0235], walls = ["vibrating"], waves = [1] }
"""


def test_a_deck_runs_from_its_file_its_keys_or_as_it_was_read(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = PROBLEMS / "sod.toml"
    first = hydro.run(path, SMALL)
    assert first.attrs["folder"] == "output/sod" and first.time.values.tolist() == [0.01, 0.02]
    keys = tomllib.loads(path.read_text()) | {"mesh": {"cells": [8, 4]}}
    for deck, folder in ((keys, "output/run"), (load(path, SMALL), "mine")):
        run = hydro.run(deck, SMALL, output=None if folder == "output/run" else folder)
        assert run.attrs["folder"] == folder and (tmp_path / folder / "summary.json").exists()
        assert (run.density.values == first.density.values).all()


def test_a_folder_with_a_run_is_not_replaced_unasked(tmp_path):
    output = tmp_path / "run"
    hydro.run(PROBLEMS / "sod.toml", SMALL, output)
    with pytest.raises(DeckError, match="--overwrite"):
        hydro.run(PROBLEMS / "sod.toml", SMALL, output)
    longer = hydro.run(PROBLEMS / "sod.toml", (*SMALL, "time.end=0.03"), output, overwrite=True)
    assert json.loads((output / "summary.json").read_text())["time"] == 0.03 and longer.time.size == 3


def test_a_run_without_states_in_time_gives_its_summary(tmp_path):
    output = tmp_path / "curves"
    summary = hydro.run(tomllib.loads(CURVES), output=output)
    assert summary["folder"] == str(output) and summary["kind"] == "stability"
    assert summary["rows"] == json.loads((output / "summary.json").read_text())["rows"]


def test_a_mistake_in_keys_is_a_complaint():
    with pytest.raises(DeckError, match=r"stability.f\[0\]"):
        hydro.run(tomllib.loads(CURVES.replace("0.0235", "2.0")))


def test_what_users_call_is_listed():
    assert {"march", "run", "open_run", "open_sweep", "read_history"} <= set(dir(hydro))
