"""Runs that cannot go on: what they say, and what they save."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest
from conftest import summary_of

from hydro.choices import INTEGRATORS
from hydro.cli import main
from hydro.dynamics import Godunov, LagrangeRemap
from hydro.dynamics.lagrange.extrapolation import unforeseen_change
from hydro.errors import RunFailed, StepRejected
from hydro.gas import Grossman
from hydro.mesh import Geometry, Mesh
from hydro.output.checkpoint import Checkpoint, read_checkpoint
from hydro.output.folder import RunFolder
from hydro.state import State, inadmissible
from hydro.walls import ElasticWall

STUCK = """
kind = "evolution"
gas = { L = 5e4, f = 0.0235, K = 2e-3 }
mesh = { cells = [8, 8] }
wall = { kind = "vibrating" }
initial = { kind = "uniform" }
time = { end = 1.0, integrator = "INTEGRATOR" }
output = { pictures = false }
"""


def get_stuck(name: str, tmp_path: Path, monkeypatch, capsys, *words: str) -> tuple[Path, str]:
    """The folder of a run that no step is possible for from t = 0.1 on, and what it says; the integrator is healed."""
    kind = INTEGRATORS[name]

    def step(self, state, dt):
        if state.time >= 0.1:
            raise StepRejected("no further, for this test")
        return sound(self, state, dt)

    sound, deck, folder = kind.step, tmp_path / "stuck.toml", tmp_path / "stuck"
    deck.write_text(STUCK.replace("INTEGRATOR", name))
    with monkeypatch.context() as patch:
        patch.setattr(kind, "step", step)
        assert main([str(deck), "time.dt_max=0.02", *words, "--output", str(folder), "--quiet"]) == 3
    return folder, capsys.readouterr().err


@pytest.mark.parametrize("name", INTEGRATORS)
def test_where_no_step_is_possible_no_restart_is_offered(name, tmp_path, monkeypatch, capsys):
    """But what has helped, and the commands that are offered can be given."""
    folder, told = get_stuck(name, tmp_path, monkeypatch, capsys)
    assert "a restart would end there at once" in told and "hydro restart" not in told
    commands = [line.strip() for line in told.splitlines() if line.startswith("  python -m hydro ")]
    assert len(commands) == len(INTEGRATORS[name].remedies) >= 1
    for command in commands:
        assert main([*shlex.split(command)[3:], "--quiet"]) == 0
    assert summary_of(Path(f"{folder}_1"))["completed"]


def test_what_a_deck_has_already_is_not_offered(tmp_path, monkeypatch, capsys):
    _, told = get_stuck("godunov", tmp_path, monkeypatch, capsys, "scheme.limiter=minmod")
    assert told.rstrip().endswith("a restart would end there at once")


@pytest.mark.parametrize("name", INTEGRATORS)
def test_the_state_of_a_run_that_fails_is_that_of_a_gas(name, tmp_path, monkeypatch, capsys):
    folder, _ = get_stuck(name, tmp_path, monkeypatch, capsys)
    saved = read_checkpoint(RunFolder(folder).saved()[-1])
    state = State(Grossman(L=5e4, K=2e-3), saved.mesh, saved.conserved)
    assert saved.time >= 0.1 and not inadmissible(state).any()


@pytest.mark.parametrize("excess", [0.0, 1e-16, 1e-15])
def test_heat_that_is_lost_in_round_off_is_no_heat(excess):
    """Kernels round otherwise than numpy: what one sees as T > 0 is T = 0 for the other."""
    gas, mesh = Grossman(L=5e4, K=2e-3), Mesh.rectangle((8, 8))
    state = State.of(gas, mesh, 0.1, 1.0, (0.3, 0.2))
    state.conserved[3, 2, 3] = (1.0 + excess) * state.kinetic_energy[2, 3]
    assert Godunov(gas, ElasticWall(), mesh).limits(state)["sound"] == 0.0
    work = LagrangeRemap(gas, ElasticWall(), mesh)._work
    assert unforeseen_change(gas, Geometry.of(mesh), state.conserved, work) == np.inf


def test_a_state_that_is_none_of_a_gas_is_not_saved(tmp_path, monkeypatch, capsys):
    """Whatever has led to it: an integrator of a user's own, say."""
    sound = Godunov.step

    def step(self, state, dt):
        amounts = sound(self, state, dt)
        if state.time > 0.1:
            state.conserved[3, 0, 0] = state.kinetic_energy[0, 0]
        return amounts

    deck, folder = tmp_path / "bad.toml", tmp_path / "bad"
    deck.write_text(STUCK.replace("INTEGRATOR", "godunov"))
    monkeypatch.setattr(Godunov, "step", step)
    words = [str(deck), "output.times=[0,0.05,0.5]", "time.dt_max=0.02", "--output", str(folder), "--quiet"]
    assert main(words) == 3
    told = capsys.readouterr().err
    assert "is not saved: 1 cells would leave 0 < n < 1, T > 0" in told or "no step is possible" in told
    gas = Grossman(L=5e4, K=2e-3)
    for path in RunFolder(folder).saved():
        saved = read_checkpoint(path)
        assert not inadmissible(State(gas, saved.mesh, saved.conserved)).any()
    bad = State.of(gas, Mesh.rectangle((8, 8)), 0.1, 0.0)
    with pytest.raises(RunFailed, match="is not saved: 64 cells would leave 0 < n < 1, T > 0"):
        Checkpoint.of(bad, "")
