"""The books of a run: where energy came from and went, summed without loss of digits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from hydro.accounts import ENERGY, Account

START = {
    "initial_energy": ("energy at the start", ENERGY),
    "initial_mass": ("mass at the start", "n_c L_x^2"),
}
# What a balance has beside the accounts.
BALANCE = {
    "change": ("change of the energy of the gas", ENERGY),
    "residual": ("what does not add up, over the wall's input", "1"),
}


@dataclass
class CompensatedSum:
    """A running sum with the rounding errors kept apart (Neumaier, Z. Angew. Math. Mech. 54, 39, 1974)."""

    total: float = 0.0
    error: float = 0.0

    def add(self, term: float) -> None:
        total = self.total + term
        larger, smaller = (self.total, term) if abs(self.total) >= abs(term) else (term, self.total)
        self.error += (larger - total) + smaller
        self.total = total

    @property
    def value(self) -> float:
        return self.total + self.error


@dataclass
class Ledger:
    """What each account has been given since the start."""

    accounts: tuple[Account, ...]
    initial_energy: float
    initial_mass: float
    sums: dict[str, CompensatedSum] = field(init=False)

    def __post_init__(self) -> None:
        self.sums = {account.name: CompensatedSum() for account in self.accounts}

    @classmethod
    def of(cls, accounts: tuple[Account, ...], entries: Mapping[str, tuple[float, float]]) -> Ledger:
        """The books whose `entries` these are; KeyError if one is missing."""
        books = cls(accounts, entries["initial_energy"][0], entries["initial_mass"][0])
        books.sums = {name: CompensatedSum(*entries[name]) for name in books.sums}
        return books

    @property
    def words(self) -> dict[str, tuple[str, str]]:
        """Long name and unit of each of the `entries`."""
        return START | {account.name: (account.long_name, account.unit) for account in self.accounts}

    @property
    def amounts(self) -> dict[str, float]:
        """What each account has been given so far."""
        return {name: kept.value for name, kept in self.sums.items()}

    def book(self, amounts: Mapping[str, float]) -> None:
        """Enter one step; KeyError for an account that nobody declared."""
        for name, amount in amounts.items():
            self.sums[name].add(amount)

    def balance(self, energy: float) -> dict[str, float]:
        """The entries, the change of energy, and what does not add up, relative to what drives the gas.

        Where that gives nothing, relative to the initial energy.
        """
        amounts = self.amounts
        entries = {account.name: amounts[account.name] for account in self.accounts if account.sign}
        change, gained, driven = energy - self.initial_energy, 0.0, 0.0
        for account in sorted(self.accounts, key=lambda account: -account.sign):  # what comes in, then what goes out
            gained += account.sign * amounts[account.name]
            driven += amounts[account.name] if account.drives else 0.0
        scale = driven if driven > 0.0 else self.initial_energy
        return {**entries, "change": change, "residual": (gained - change) / scale}

    def entries(self) -> dict[str, tuple[float, float]]:
        """All numbers of the books, as pairs (sum, compensation)."""
        start = {"initial_energy": (self.initial_energy, 0.0), "initial_mass": (self.initial_mass, 0.0)}
        return start | {name: (kept.total, kept.error) for name, kept in self.sums.items()}
