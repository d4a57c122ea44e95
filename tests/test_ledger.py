"""The books of energy: what an integrator declares is in all that a run leaves behind."""

from __future__ import annotations

import csv

import h5py
import numpy as np
import pytest
from conftest import differences, outcome, restart, summary_of

from hydro.accounts import SOURCE, WALL, Account
from hydro.cli import main
from hydro.driver.ledger import CompensatedSum, Ledger
from hydro.dynamics import Godunov
from hydro.output.folder import RunFolder
from hydro.setup import terms_of, wall_of

POWER = 0.01
FROM_SHAKING = "energy from shaking the box"
SMALL = (
    "mesh.cells=[8,16]", "time.integrator=godunov", "time.end=1.0", "output.times=[0.5,1.0]", "output.pictures=false",
)  # fmt: skip


def test_compensated_sum_loses_no_digits():
    kept = CompensatedSum()
    for term in [1.0, 1e100, 1.0, -1e100]:
        kept.add(term)
    assert kept.value == 2.0


def test_residual_is_what_the_accounts_do_not_explain():
    lost = Account("radiation", -1, "energy radiated")
    books = Ledger((WALL, lost, SOURCE), initial_energy=10.0, initial_mass=1.0)
    books.book({"wall": 4.0, "radiation": 1.0})
    books.book({"source": 0.5})
    found = books.balance(13.0)
    assert list(found) == ["wall", "radiation", "source", "change", "residual"]
    assert found["radiation"] == 1.0 and found["change"] == 3.0 and found["residual"] == (3.5 - 3.0) / 4.0
    with pytest.raises(KeyError, match="gravity"):
        books.book({"gravity": 1.0})


class Shaken(Godunov):
    """Godunov in a box that heats the gas evenly: an account, a step limit and a memory of its own."""

    remembered = {**Godunov.remembered, "shakes": ("number of shakes", "1")}  # noqa: RUF012

    def __init__(self, *args, **options):
        super().__init__(*args, **options)
        self.accounts = (*self.accounts, Account("shaking", 1, FROM_SHAKING))
        self.step_limits = (*self.step_limits, "shaking")
        self.shakes = 0

    def limits(self, state):
        return {**super().limits(state), "shaking": 0.004}

    def step(self, state, dt):
        amounts = super().step(state, dt)
        state.conserved[3] += POWER * dt
        self.shakes += 1
        return {**amounts, "shaking": POWER * dt * state.mesh.aspect_ratio}

    def memory(self):
        return {**super().memory(), "shakes": np.array([self.shakes])}

    def remember(self, memory):
        super().remember(memory)
        self.shakes = int(memory["shakes"][0])


@pytest.fixture
def shaken(monkeypatch):
    """Decks get the integrator of the shaken box."""
    from hydro.kinds import evolution

    def made(deck, state):
        return Shaken(state.gas, wall_of(deck), state.mesh, terms_of(deck))

    monkeypatch.setattr(evolution, "integrator_of", made)


def test_an_account_of_its_own_is_in_all_that_a_run_leaves(shaken, run_deck):
    folder, code = run_deck("fig4", *SMALL)
    summary = summary_of(folder)
    books = summary["energy_ledger"]
    assert code == 0
    assert list(books) == ["wall", "collisions", "friction", "source", "internal", "shaking", "change", "residual"]
    assert books["shaking"] == pytest.approx(POWER * 2.0, rel=1e-12) and abs(books["residual"]) < 1e-11
    assert list(summary["steps_by"]) == ["sound", "remap", "error", "shaking", "dt_max", "rejection", "output"]
    assert summary["steps_by"]["shaking"] > 100
    with (folder / "history.csv").open() as file:
        last = list(csv.DictReader(file))[-1]
    assert float(last["shaking"]) == books["shaking"]
    assert float(last["steps_by_shaking"]) == summary["steps_by"]["shaking"]
    with h5py.File(RunFolder(folder).saved()[-1]) as file:
        entry, memory = file["ledger/shaking"], file["integrator/shakes"]
        assert entry[:].sum() == books["shaking"] and entry.attrs["long_name"] == FROM_SHAKING
        assert entry.attrs["units"] == "n_c T_* L_x^2" and memory.attrs["long_name"] == "number of shakes"
    assert main(["report", str(folder), "--quiet"]) == 0
    page = (folder / "report.html").read_text()
    assert FROM_SHAKING in page and "energy from the driving wall" in page and "energy lost in collisions" in page


def test_a_restart_goes_on_with_an_account_of_its_own(shaken, run_deck):
    folder, _ = run_deck("fig4", *SMALL)
    expected = outcome(folder)
    RunFolder(folder).saved()[-1].unlink()
    assert restart(folder) == 0 and not differences(folder, expected)
