"""A set of observables of its own is in all that a run leaves, without a change elsewhere."""

from __future__ import annotations

import csv
import re

import h5py
import pytest
from conftest import differences, outcome, restart, summary_of

from hydro.choices import OBSERVABLES
from hydro.cli import main
from hydro.deck import load
from hydro.observables import CLUSTERING, observables_of
from hydro.observables.general import extended, kinetic_energy
from hydro.observables.sets import Curve, Panel, Quantity
from hydro.output.folder import RunFolder

SMALL = ("mesh.cells=[8,16]", "time.end=1.0", "output.times=[0.5,1.0]", "time.integrator=godunov")
HOT = "about.title=hot"
MEAN = Quantity(
    "mean_temperature", "mean temperature", "T_*",
    lambda state, _: float((state.energy - kinetic_energy(state, None)) / state.mass), "mean T",
)  # fmt: skip
SHARE = Quantity(
    "kinetic_share", "energy of the flow over all energy", "1",
    lambda state, _: kinetic_energy(state, None) / state.energy, "kinetic share",
)  # fmt: skip
TEMPERATURES = extended(
    "temperatures",
    fits=lambda deck: deck.about.title == "hot",
    summary=(MEAN, SHARE),
    closing=(("mean_temperature", "mean T", ".6f"), ("kinetic_share", "share", ".3e")),
    compared=(MEAN,),
    panels=(Panel("The mean temperature", "mean $T/T_*$", (Curve("mean_temperature"),)),),
    overlaid=(Panel("The mean temperature", "mean $T/T_*$", (Curve("mean_temperature"),)),),
)
GRAINY = extended("grainy", lambda deck: True, (MEAN,), estimated=(MEAN,), closing=(("mean_temperature", "T", ".4f"),))


@pytest.fixture(autouse=True)
def _entered(monkeypatch):
    monkeypatch.setitem(OBSERVABLES._entries, TEMPERATURES.name, f"{__name__}:TEMPERATURES")


@pytest.fixture
def labels(monkeypatch):
    """Labels of all axes in pictures that are drawn."""
    from hydro.pictures import history, overlay

    found = []
    for module in (history, overlay):
        monkeypatch.setattr(module, "save", lambda figure, path: found.extend(a.get_ylabel() for a in figure.axes))
    return found


def test_a_set_of_its_own_is_in_all_that_a_run_leaves(run_deck, labels, capsys):
    folder, code = run_deck("fig4", *SMALL, HOT, options=())
    said, summary = capsys.readouterr().out, summary_of(folder)
    last = summary["snapshots"][-1]
    assert code == 0 and summary["observables"] == "temperatures"
    own = ["mean_temperature", "kinetic_share"]
    assert list(last) == ["time", *own, "mean_pressure", "max_speed", "max_mach", "checkpoint"]
    with (folder / "history.csv").open() as file:
        row = list(csv.DictReader(file))[-1]
    assert list(row)[:6] == ["time", *own, "mean_pressure", "max_speed", "max_mach"] and "wall_max" not in row
    assert float(row["mean_temperature"]) == last["mean_temperature"] > 0.0
    assert f"mean T {last['mean_temperature']:.6f}  share {last['kinetic_share']:.3e}  Mach" in said
    assert labels[0] == "mean $T/T_*$" and "density $n/n_c$" not in labels
    with h5py.File(RunFolder(folder).saved()[-1]) as file:
        saved = file["snapshots/mean_temperature"]
        assert saved[-1] == last["mean_temperature"] and saved.attrs["long_name"] == "mean temperature"
    assert main(["report", str(folder), "--quiet"]) == 0
    page = (folder / "report.html").read_text()
    assert "mean T" in page and "n(0, y)" not in page


def test_overlay_and_movie_show_a_set_of_its_own(run_deck, labels, tmp_path, capsys):
    folder, _ = run_deck("fig4", *SMALL, HOT)
    assert main(["overlay", str(folder), "--output", str(tmp_path / "over")]) == 0
    assert re.search(r" t +mean T\n", capsys.readouterr().out) and labels[-1] == "mean $T/T_*$"
    assert main(["movie", str(folder), "gif=false", "--quiet"]) == 0 and (folder / "movie.mp4").stat().st_size


def test_a_restart_goes_on_with_a_set_of_its_own(run_deck):
    folder, _ = run_deck("fig4", *SMALL, HOT)
    expected = outcome(folder)
    RunFolder(folder).saved()[-1].unlink()
    assert restart(folder) == 0 and not differences(folder, expected)


def test_grains_have_the_errors_that_a_set_asks_for(run_deck, monkeypatch, capsys):
    monkeypatch.setitem(OBSERVABLES._entries, GRAINY.name, f"{__name__}:GRAINY")
    words = ("time.end=0.5", "output.times=[0.5]", "output.pictures=false")
    folder, code = run_deck("grains_cooling", *words, options=())
    row = summary_of(folder)["snapshots"][-1]
    assert code == 0 and list(row)[:5] == [
        "time", "mean_temperature", "thermal_energy", "mean_temperature_error", "thermal_energy_error",
    ]  # fmt: skip
    assert 0.0 < row["mean_temperature_error"] < row["mean_temperature"]
    shown = f"T {row['mean_temperature']:.4f} ± {row['mean_temperature_error']:.4f}\n"
    assert shown in capsys.readouterr().out


def test_decks_of_today_have_the_clustering_set():
    from conftest import PROBLEMS

    assert observables_of(load(PROBLEMS / "fig4.toml")) is CLUSTERING
    assert observables_of(load(PROBLEMS / "sod.toml")) is CLUSTERING


def test_every_curve_and_closing_word_of_a_set_is_one_of_its_quantities():
    names = CLUSTERING.quantities.keys()
    curves = [curve.column for panel in (*CLUSTERING.panels, *CLUSTERING.overlaid) for curve in panel.curves]
    assert {*curves, *CLUSTERING.drifting, *(name for name, _, _ in CLUSTERING.closing)} <= names
