"""Every deck of problems/, at small size, with stored norms.

`python tests/test_decks.py` writes the norms anew, after a change that is meant to change results.
"""

from __future__ import annotations

import json
import tempfile
import tomllib
from pathlib import Path

import numpy as np
import pytest
from conftest import PROBLEMS, summary_of

from hydro.cli import main
from hydro.output.checkpoint import read_checkpoint
from hydro.studies.sweep import open_sweep

SMALL = {
    "fig4": ("mesh.cells=[16,32]", "time.end=5.0", "output.times=[2.0,5.0]"),
    "ratio1": ("mesh.cells=[16,16]", "time.end=5.0", "output.times=[5.0]"),
    "ratio3": ("mesh.cells=[8,24]", "time.end=5.0", "output.times=[5.0]"),
    "sod": ("mesh.cells=[100,4]",),
    "cooling": ("mesh.cells=[8,8]",),
    "noise": ("mesh.cells=[16,32]", "time.end=5.0", "output.times=[5.0]"),
    "free_cooling": ("mesh.cells=[16,16]", "time.end=2.0", "output.times=[2.0]", "output.movie=false"),
    "coarsening": ("mesh.cells=[8,64]", "time.end=5.0", "output.times=[5.0]"),
    "experiment": ("mesh.cells=[16,32]", "time.end=5.0", "output.times=[5.0]"),
    "experiment_stable": ("mesh.cells=[16,16]", "time.end=5.0", "output.times=[5.0]"),
    "fig1": ("stability.L=[1e3, 1e6]", "stability.f.count=5"),
    "fig2": ("stability.f.count=4",),
    "fig3a": ("mesh.cells=[16,16]",),
    "fig3b": ("mesh.cells=[16,32]",),
    "fig3c": ("mesh.cells=[32,32]",),
    "fig3d": ("mesh.cells=[32,64]",),
    "convergence_manufactured": ("convergence.ladder.values=[[[16,24],6.25e-3],[[32,48],3.125e-3]]",),
    "convergence_sound": ("convergence.ladder.values=[[[32,4],2e-3],[[64,4],1e-3]]",),
    "convergence_isobaric": ("convergence.ladder.values=[[[32,4],4e-3],[[64,4],2e-3]]",),
    "convergence_cooling": ("convergence.ladder.values=[0.0125,0.00625]",),
    "convergence_conduction": ("convergence.ladder.values=[[[16,4],8e-3],[[32,4],4e-3]]",),
    "convergence_viscosity": ("convergence.ladder.values=[[[16,4],8e-3],[[32,4],4e-3]]",),
    "convergence_steady": ("convergence.ladder.values=[[16,16],[32,32],[64,64]]",),
    "convergence_fig4_grid": (
        "base.time.end=2.0",
        "base.output.times=[2.0]",
        "convergence.ladder.values=[[8,16],[16,32]]",
    ),
    "convergence_fig4_step": (
        "base.time.end=2.0",
        "base.output.times=[2.0]",
        "base.mesh.cells=[8,16]",
        "convergence.ladder.values=[[0.8,3e-4],[0.4,7.5e-5]]",
    ),
    "map": (
        "base.time.end=2.0",
        "base.output.times=[1.0,2.0]",
        "sweep.axes=[{keys=['gas.f'],values=[0.02,0.03]},{keys=['box.aspect_ratio','mesh.cells'],values=[[0.5,[8,4]],[1.0,[8,8]]]}]",
    ),
    "hysteresis": (
        "base.mesh.cells=[8,8]",
        "base.time.end=2.0",
        "base.output.times=[1.0,2.0]",
        "sweep.axes=[{keys=['gas.f'],values=[0.02,0.03,0.02]}]",
    ),
    "folds": (
        "base.mesh.cells=[16,16]",
        "base.branch.step=0.5",
        "sweep.axes=[{keys=['box.aspect_ratio'],values=[2.0]}]",
    ),
    "branches": ("mesh.cells=[16,16]", "branch.samples=9", "branch.step=0.5"),
    "grains_cooling": ("time.end=1.0", "output.times=[1.0]"),
    "grains_free_cooling": ("gas.f=0.02", "time.end=1.0", "output.times=[1.0]", "output.history_every=0.1"),
    "grains_extended": ("time.end=0.1", "output.times=[0.1]", "grains.window=0.1"),
    "grains_small": ("time.end=0.1", "output.times=[0.1]", "grains.window=0.1"),
    "grains_seeds": (
        "base.time.end=0.1",
        "base.output.times=[0.1]",
        "base.grains.window=0.1",
        "sweep.axes=[{keys=['gas.L'],values=[50.0]},{keys=['grains.seed'],values=[1,2]}]",
    ),
    "grains_fig4": ("time.end=0.02", "output.times=[0.02]", "grains.window=0.02"),
    "grains_matched": ("gas.K=1e-2", "time.end=0.02", "output.times=[0.02]", "grains.window=0.02"),
}
NORMS = Path(__file__).with_name("norms.json")


def evolution_norms(folder: Path) -> dict[str, float]:
    """Norms of the last state."""
    saved = read_checkpoint(sorted(folder.glob("checkpoints/*.h5"))[-1])
    density, energy = saved.conserved[0], saved.conserved[3]
    return {
        "steps": saved.steps,
        "density_l2": float(np.sqrt(saved.mesh.integral(density**2))),
        "density_max": float(density.max()),
        "energy_l1": saved.mesh.integral(energy),
        "energy_max": float(energy.max()),
    }


def stability_norms(folder: Path) -> dict[str, float]:
    """Critical aspect ratios and tongues, added up."""
    summary = summary_of(folder)
    ratios = [row["aspect_ratio"] for row in summary["rows"] if row["aspect_ratio"] is not None]
    tongues = summary["tongues"]
    ends = {key: sum(tongue[key] for tongue in tongues) for key in ("f1", "f2", "f_min", "aspect_ratio_min")}
    return {"rows": len(summary["rows"]), "critical": len(ratios), "aspect_ratios": sum(ratios), **ends}


def steady_norms(folder: Path) -> dict[str, float]:
    """The wall densities and growth rates."""
    summary = summary_of(folder)
    return {key: summary[key] for key in ("wall_max", "wall_min", "gas_density", "pressure", "growth_rate")}


def branch_norms(folder: Path) -> dict[str, float]:
    """Bifurcations and folds."""
    summary = summary_of(folder)
    places = {f"bifurcation {number}": entry["f"] for number, entry in enumerate(summary["bifurcations"])}
    folds = {f"fold {number}": entry["f"] for number, entry in enumerate(summary["folds"])}
    return {**places, **folds, "stable": sum(point["stable"] for point in summary["points"])}


def grains_norms(folder: Path) -> dict[str, float]:
    """How many there are and what they have done: little, for collisions magnify rounding."""
    summary = summary_of(folder)
    ledger, last = summary["energy_ledger"], summary["snapshots"][-1]
    told = ("wall_max", "wall_min", "gas_density", "mean_temperature", "thermal_energy")
    measured = {key: last[key] for key in told if key in last}
    return {"grains": summary["grains"], "collisions": summary["collisions"], "lost": ledger["collisions"], **measured}


def convergence_norms(folder: Path) -> dict[str, float]:
    """Sums of errors, and scalars, of all levels."""
    rows = summary_of(folder)["rows"]
    errors = {f"error {k}": row["errors"]["total"] for k, row in enumerate(rows) if row["errors"]["total"] is not None}
    return errors | {f"{name} {k}": value for k, row in enumerate(rows) for name, value in row["scalars"].items()}


def sweep_norms(folder: Path) -> dict[str, float]:
    """The first scalar of all members."""
    table = open_sweep(folder)
    first = next(name for name in table.data_vars if name not in ("member", "completed"))
    return {f"{first} {k}": float(value) for k, value in enumerate(table[first].values.ravel())}


NORMS_OF = {
    "evolution": evolution_norms,
    "stability": stability_norms,
    "steady": steady_norms,
    "branch": branch_norms,
    "grains": grains_norms,
    "convergence": convergence_norms,
    "sweep": sweep_norms,
}


def norms(name: str, folder: Path) -> dict[str, float]:
    """Norms of what a deck gives, run at small size."""
    deck = PROBLEMS / f"{name}.toml"
    assert main([str(deck), *SMALL[name], "--output", str(folder), "--quiet"]) == 0
    return NORMS_OF[tomllib.loads(deck.read_text(encoding="utf-8"))["kind"]](folder)


def test_every_deck_has_a_small_size():
    assert set(SMALL) == {deck.stem for deck in PROBLEMS.glob("*.toml")}


@pytest.mark.parametrize("name", SMALL)
def test_deck_gives_its_stored_norms(name, tmp_path):
    assert norms(name, tmp_path / name) == pytest.approx(json.loads(NORMS.read_text())[name], rel=1e-8)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        stored = {name: norms(name, Path(scratch) / name) for name in SMALL}
    NORMS.write_text(json.dumps(stored, indent=2) + "\n")
