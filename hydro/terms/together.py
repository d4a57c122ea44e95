"""All terms of a problem together, as integrators ask for them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from hydro.accounts import Account
from hydro.gas import Closure
from hydro.mesh import Mesh
from hydro.state import State
from hydro.terms.term import Stress, Term
from hydro.walls.boundary import Boundary


class Terms:
    """Sums over terms, and the accounts under which their energies are booked."""

    def __init__(self, terms: Iterable[Term] = ()):
        self.terms = tuple(terms)
        self.drag_rate = sum(term.drag_rate() for term in self.terms)

    @property
    def accounts(self) -> tuple[Account, ...]:
        """The accounts of the terms, each once."""
        return tuple(dict.fromkeys(term.account for term in self.terms if term.account is not None))

    @property
    def limiting(self) -> bool:
        """Whether one of them may limit the step."""
        return any(type(term).largest_step is not Term.largest_step for term in self.terms)

    @property
    def forcing(self) -> bool:
        """Whether one of them is a force."""
        return any(type(term).acceleration is not Term.acceleration for term in self.terms)

    def limits(self, state: State) -> dict[str, float]:
        """The longest step that they allow, under the name `terms`; nothing where none limits it."""
        return {"terms": min(term.largest_step(state) for term in self.terms)} if self.limiting else {}

    def rates(self, time: float, mesh: Mesh) -> list[tuple[str, np.ndarray]]:
        """What they add to the rates of the conserved fields, each (4, nx, ny), with the names of their accounts."""
        return named((term, term.rates(time, mesh)) for term in self.terms)

    def forces(self, time: float, state: State) -> list[tuple[str, np.ndarray]]:
        """Their forces per mass, each (2, nx, ny), with the names of their accounts."""
        return named((term, term.acceleration(time, state)) for term in self.terms)

    def drag_losses(self, lost: float) -> dict[str, float]:
        """Energy lost by drag, by account: in proportion to the rates."""
        shares: dict[str, float] = {}
        for term in self.terms:
            if term.drag_rate() > 0.0 and term.account is not None:
                part = lost * term.drag_rate() / self.drag_rate
                shares[term.account.name] = shares.get(term.account.name, 0.0) + part
        return shares

    def stresses(self, gas: Closure, boundary: Boundary, mesh: Mesh) -> list[Stress]:
        """The stresses in a gas between walls on a mesh."""
        found = (term.stress(gas, boundary, mesh) for term in self.terms)
        return [stress for stress in found if stress is not None]


def named(given: Iterable[tuple[Term, np.ndarray | None]]) -> list[tuple[str, np.ndarray]]:
    """Fields that there are, with the names of the accounts of their terms."""
    return [(term.account.name, field) for term, field in given if field is not None and term.account is not None]
