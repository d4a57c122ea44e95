"""Sound that the implicit integrator does not resolve is never silent."""

from __future__ import annotations

import json

import numpy as np
import pytest

from hydro.check.scales import report
from hydro.cli import main
from hydro.deck import parse
from hydro.dynamics.lagrange.sound import RESOLVED, Sound, Unresolved, resolving_step
from hydro.mesh import Mesh
from hydro.output.checkpoint import read_checkpoint
from hydro.state import State
from hydro.verification.implicit import start_of_fig4
from hydro.verification.setups import IDEAL

DECK = """
kind = "evolution"
gas = { L = 0.0, f = 0.3, K = 0.02, viscosity = 1.0 }
box = { periodic = ["x", "y"] }
mesh = { cells = [32, 4] }
wall = { kind = "elastic" }
initial = { kind = "eigenmode", mode = "sound", amplitude = 1e-4 }
time = { end = 1.0, integrator = "lagrange-remap" }
output = { pictures = false }
"""
LEFT = 0.2285  # of the amplitude at t = 1, by the linear mode


def amplitude_left(folder):
    """That of the density, over that at the start."""
    density = read_checkpoint(sorted(folder.glob("checkpoints/*.h5"))[-1]).conserved[0][:, 0]
    return 2.0 * abs(np.fft.rfft(density)[1]) / density.size / (0.3 * 1e-4)


@pytest.fixture
def run_sound(tmp_path):
    """Runs the deck with overrides: (folder, summary)."""

    def run(*overrides):
        deck, folder = tmp_path / "sound.toml", tmp_path / "run"
        deck.write_text(DECK)
        assert main([str(deck), *overrides, "--output", str(folder)]) == 0
        return folder, json.loads((folder / "summary.json").read_text())

    return run


def test_sound_that_is_lost_is_told(run_sound, capsys):
    folder, summary = run_sound()
    assert amplitude_left(folder) < 0.6 * LEFT
    assert summary["sound_resolved"] is False
    assert summary["steps_per_sound_period"] < RESOLVED
    assert summary["unresolved_sound"] == pytest.approx(7e-5, rel=0.2)
    advice = f"time.dt_max = {summary['dt_for_sound']:.2g} follows it"
    assert (
        f"{summary['steps_per_sound_period']:.1f} steps in the period of the slowest; {advice}"
        in capsys.readouterr().out
    )


def test_the_step_that_is_named_follows_the_sound(run_sound, capsys):
    step = resolving_step(Sound.of(State.of(IDEAL, Mesh.rectangle((8, 8)), 0.3, 1.0)).period / 2.0)
    folder, summary = run_sound(f"time.dt_max={step:.2g}")
    assert amplitude_left(folder) == pytest.approx(LEFT, rel=0.03)
    assert summary["sound_resolved"] is True
    assert "sound of an amplitude" not in capsys.readouterr().out


def test_the_explicit_integrator_follows_sound(run_sound):
    _, summary = run_sound("time.integrator=godunov")
    assert summary["sound_resolved"] is True


@pytest.mark.parametrize(
    ("replaced", "by", "warned"),
    [
        ("amplitude = 1e-4", "amplitude = 1e-4", True),
        ("amplitude = 1e-4", "amplitude = 1e-2", False),
        ("end = 1.0", "end = 1.0, dt_max = 0.01", False),
        ("lagrange-remap", "godunov", False),
        ('mode = "sound"', 'mode = "heat"', False),
    ],
)
def test_check_says_it_beforehand(replaced, by, warned):
    lines = report(parse(DECK.replace(replaced, by)))
    assert any("sound is not resolved" in line and "about 3.0 steps" in line for line in lines) == warned


def test_slow_flow_and_gas_that_is_held_are_no_sound():
    mesh = Mesh.rectangle((32, 32), periodic=(True, True))
    x, y = 2.0 * np.pi * mesh.x[:, None], 2.0 * np.pi * mesh.y
    vortices = (1e-3 * np.sin(x) * np.cos(y), -1e-3 * np.cos(x) * np.sin(y))
    dp = 0.25 * 0.3 * 1e-6 * (np.cos(2.0 * x) + np.cos(2.0 * y))
    T = IDEAL.temperature(0.3, IDEAL.pressure(0.3, 1.0) + dp)
    assert Sound.of(State.of(IDEAL, mesh, 0.3, T, vortices)).amplitude == 0.0
    held = State.of(IDEAL, mesh, 0.3, 1.0 + 0.1 * np.cos(x) + 0.0 * y, vortices)
    assert Sound.of(held).amplitude == 0.0
    wave = State.of(IDEAL, mesh, 0.3 * (1.0 + 1e-3 * np.sin(x) + 0.0 * y), 1.0, (2e-3 * np.sin(x) + 0.0 * y, 0.0))
    assert Sound.of(wave).amplitude == pytest.approx(1e-3, rel=0.5)


def test_walls_have_twice_the_period_and_the_longer_side_counts():
    both = [start_of_fig4(8), State.of(IDEAL, Mesh.rectangle((8, 8), 0.5, periodic=(True, True)), 0.3, 1.0)]
    speeds = [float(np.mean(state.gas.sound_speed(state.density, state.temperature))) for state in both]
    periods = [Sound.of(state).period for state in both]
    assert periods == pytest.approx([4.0 / speeds[0], 1.0 / speeds[1]], rel=1e-3)


def test_the_largest_amplitude_and_the_fewest_steps_are_kept():
    seen = Unresolved()
    assert seen.summary() == {"sound_resolved": True}
    for amplitude, dt in ((1e-3, 0.01), (1e-4, 0.1), (1e-5, 0.2), (0.0, 1.0)):
        seen.note(Sound(amplitude, 1.0), dt)
    said = seen.summary()
    assert said == pytest.approx(
        {
            "sound_resolved": False,
            "unresolved_sound": 1e-4,
            "steps_per_sound_period": 5.0,
            "dt_for_sound": resolving_step(1.0),
        }
    )
