"""All terms of a problem together, as integrators ask for them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from hydro.accounts import Account
from hydro.gas import Closure
from hydro.mesh import Mesh
from hydro.state import State
from hydro.terms.term import Stress, Term
from hydro.walls.boundary import Boundary


class Given(NamedTuple):
    """A field that a term gives, and the account under which its energy is booked, if under any."""

    account: Account | None
    field: np.ndarray


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
    def limiting(self) -> dict[str, list[Term]]:
        """Those that may limit the step, by name."""
        found: dict[str, list[Term]] = {}
        for term in self.terms:
            if type(term).largest_step is not Term.largest_step:
                found.setdefault(term.name, []).append(term)
        return found

    @property
    def forcing(self) -> bool:
        """Whether one of them is a force."""
        return any(type(term).acceleration is not Term.acceleration for term in self.terms)

    def limits(self, state: State) -> dict[str, float]:
        """The longest steps that they allow, by the names of the terms that limit it."""
        return {name: min(term.largest_step(state) for term in terms) for name, terms in self.limiting.items()}

    def rates(self, time: float, mesh: Mesh) -> list[Given]:
        """What they add to the rates of the conserved fields, each (4, nx, ny); ValueError for another shape."""
        return given(((term, term.rates(time, mesh)) for term in self.terms), (4, *mesh.cells))

    def forces(self, time: float, state: State) -> list[Given]:
        """Their forces per mass, each (2, nx, ny); ValueError for another shape."""
        return given(((term, term.acceleration(time, state)) for term in self.terms), (2, *state.mesh.cells))

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


def given(fields: Iterable[tuple[Term, np.ndarray | None]], shape: tuple[int, ...]) -> list[Given]:
    """Those fields that there are, with the accounts of their terms."""
    found = []
    for term, field in fields:
        if field is None:
            continue
        if np.shape(field) != shape:
            raise ValueError(f"{type(term).__name__} gives a field of shape {np.shape(field)}; {shape} is wanted")
        found.append(Given(term.account, field))
    return found
