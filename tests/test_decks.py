"""Every deck of problems/, at small size, with stored norms.

`python tests/test_decks.py` writes the norms anew, after a change that is meant to change results.
"""

from __future__ import annotations

import json
import tempfile
from pathlib import Path

import numpy as np
import pytest
from conftest import PROBLEMS

from hydro.cli import main
from hydro.runs.checkpoint import read_checkpoint

SMALL = {
    "fig4": ("mesh.cells=[16,32]", "time.end=5.0", "output.times=[2.0,5.0]"),
    "sod": ("mesh.cells=[100,4]",),
    "cooling": ("mesh.cells=[8,8]",),
    "noise": ("mesh.cells=[16,32]", "time.end=5.0", "output.times=[5.0]"),
}
NORMS = Path(__file__).with_name("norms.json")


def norms(name: str, folder: Path) -> dict[str, float]:
    """Norms of the last state of a deck, run at small size."""
    assert main([str(PROBLEMS / f"{name}.toml"), *SMALL[name], "--output", str(folder), "--quiet"]) == 0
    saved = read_checkpoint(sorted(folder.glob("checkpoints/*.h5"))[-1])
    density, energy = saved.conserved[0], saved.conserved[3]
    return {
        "steps": saved.steps,
        "density_l2": float(np.sqrt(saved.mesh.integral(density**2))),
        "density_max": float(density.max()),
        "energy_l1": saved.mesh.integral(energy),
        "energy_max": float(energy.max()),
    }


def test_every_deck_has_a_small_size():
    assert set(SMALL) == {deck.stem for deck in PROBLEMS.glob("*.toml")}


@pytest.mark.parametrize("name", SMALL)
def test_deck_gives_its_stored_norms(name, tmp_path):
    assert norms(name, tmp_path / name) == pytest.approx(json.loads(NORMS.read_text())[name], rel=1e-8)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        stored = {name: norms(name, Path(scratch) / name) for name in SMALL}
    NORMS.write_text(json.dumps(stored, indent=2) + "\n")
