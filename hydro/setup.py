"""From a deck to the things it names: gas, mesh, wall, terms."""

from __future__ import annotations

import math
from typing import Any

from hydro.gas import CLOSURES, Closure
from hydro.mesh import Mesh
from hydro.terms import TERMS, Term
from hydro.walls import WALLS


def gas_of(deck: Any) -> Closure:
    """The closure named by the deck, with its constants. A branch in L gets its L later."""
    L = math.nan if deck.gas.L is None else deck.gas.L
    return CLOSURES[deck.gas.closure](L=L, K=deck.gas.K, alpha=deck.gas.alpha)


def mesh_of(deck: Any) -> Mesh:
    """The deck's mesh."""
    along = getattr(deck.box, "periodic", ())
    return Mesh.rectangle(deck.mesh.cells, deck.box.aspect_ratio, deck.mesh.stretch, ("x" in along, "y" in along))


def wall_of(deck: Any):
    """The law of the driving wall; its parameters are the keys of the section beside `kind`, with K W instead of W."""
    given = deck.wall.model_dump(exclude={"kind"})
    if "W" in given:
        given["strength"] = deck.gas.K * given.pop("W")
    return WALLS[deck.wall.kind](**given)


def terms_of(deck: Any) -> list[Term]:
    """The terms beside flow and heat that the deck names."""
    return [term.of(deck) for term in TERMS]


def grain_diameter(deck: Any) -> float:
    """d/L_x = K/mu of a deck with gas."""
    return deck.gas.K / deck.gas.mu


def viscosity_of(deck: Any) -> float:
    """Viscosity over that of the closure; zero for decks that know none."""
    return getattr(deck.gas, "viscosity", 0.0)
