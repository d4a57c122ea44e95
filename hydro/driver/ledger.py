"""The books of a run: where energy came from and went, summed without loss of digits."""

from __future__ import annotations

from dataclasses import dataclass, field

from hydro.dynamics.integrator import Exchange


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
    """Energy given by the wall and by added sources, lost in collisions and by friction, since the start."""

    initial_energy: float
    initial_mass: float
    sums: dict[str, CompensatedSum] = field(init=False)

    def __post_init__(self) -> None:
        self.sums = {name: CompensatedSum() for name in Exchange._fields}

    @classmethod
    def of(cls, entries: dict[str, tuple[float, float]]) -> Ledger:
        """The books whose `entries` these are; KeyError if one is missing."""
        books = cls(entries["initial_energy"][0], entries["initial_mass"][0])
        books.sums = {name: CompensatedSum(*entries[name]) for name in books.sums}
        return books

    def book(self, exchange: Exchange) -> None:
        """Enter one step."""
        for name, amount in zip(exchange._fields, exchange, strict=True):
            self.sums[name].add(amount)

    def balance(self, energy: float) -> dict[str, float]:
        """The entries, the change of energy, and what does not add up, relative to the wall's input.

        Where the wall gives nothing, relative to the initial energy.
        """
        entries = {name: kept.value for name, kept in self.sums.items()}
        change = energy - self.initial_energy
        gained = entries["wall"] + entries["source"] - entries["collisions"] - entries["friction"]
        scale = entries["wall"] if entries["wall"] > 0.0 else self.initial_energy
        return {**entries, "change": change, "residual": (gained - change) / scale}

    def entries(self) -> dict[str, tuple[float, float]]:
        """All numbers of the books, as pairs (sum, compensation)."""
        start = {"initial_energy": (self.initial_energy, 0.0), "initial_mass": (self.initial_mass, 0.0)}
        return start | {name: (kept.total, kept.error) for name, kept in self.sums.items()}
