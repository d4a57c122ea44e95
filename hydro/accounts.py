"""Accounts: the names under which a run books the energy that comes and goes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

ENERGY = "n_c T_* L_x^2"  # unit of the books


class Account(NamedTuple):
    """An entry of the energy ledger. What takes energy from the gas, or gives it some, declares one.

    name: column of the history, key of the summary. sign: 1 where amounts are energy that the gas is given, -1 where
    they are energy that it loses; an amount may be negative, as that of a wall which takes heat. drives: whether the
    residual of the books is relative to this account. A sign of 0 is that of a count, which is no energy.
    """

    name: str
    sign: int
    long_name: str
    unit: str = ENERGY
    drives: bool = False


WALL = Account("wall", 1, "energy from the driving wall", drives=True)
COLLISIONS = Account("collisions", -1, "energy lost in collisions")
FRICTION = Account("friction", -1, "energy of the flow lost by rolling friction")
SOURCE = Account("source", 1, "energy from added sources")
INTERNAL = Account("internal", 1, "energy that balances of internal energy add where gas is cold and packed")


class Amounts(dict[str, float]):
    """Energies, or powers, by the names of accounts."""

    @classmethod
    def of(cls, accounts: Iterable[Account]) -> Amounts:
        """Zero for every account."""
        return cls({account.name: 0.0 for account in accounts})

    def add_to(self, account: Account | None, amount: float) -> None:
        """Add an amount to an account, if there is one."""
        if account is not None:
            self[account.name] += amount

    def add(self, amounts: Mapping[str, float]) -> None:
        """Add to what is there."""
        for name, amount in amounts.items():
            self[name] += amount
