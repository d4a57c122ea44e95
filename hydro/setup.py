"""From a deck to the things it names: gas, mesh, wall, terms, integrator."""

from __future__ import annotations

from typing import Any

from hydro.choices import INTEGRATORS, TERMS
from hydro.gas import Closure
from hydro.gas.elastic import ELASTIC_BELOW
from hydro.mesh import Mesh
from hydro.state import State


def gas_of(deck: Any, **given: float) -> Closure:
    """The closure named by the deck, with its constants, or with others that are given.

    A branch in L gets its L later.
    """
    return deck.gas.law(**given)


def mesh_of(deck: Any) -> Mesh:
    """The deck's mesh."""
    along = getattr(deck.box, "periodic", ())
    return Mesh.rectangle(deck.mesh.cells, deck.box.aspect_ratio, deck.mesh.stretch, ("x" in along, "y" in along))


def wall_of(deck: Any) -> Any:
    """The law of the driving wall. Decks give the strength of one that vibrates over K."""
    return deck.wall.law(K=deck.gas.K)


def terms_of(deck: Any) -> list[Any]:
    """The terms beside flow and heat: those that the deck names, and those of its initial state."""
    named = (TERMS[name].of(deck) for name in TERMS)
    return [*(term for term in named if term is not None), *deck.initial.terms(deck)]


def grain_diameter(deck: Any) -> float:
    """d/L_x = K/mu of a deck with gas."""
    return deck.gas.K / deck.gas.mu


def viscosity_of(deck: Any) -> float:
    """Viscosity over that of the closure; zero for decks that know none."""
    return getattr(deck.gas, "viscosity", 0.0)


def elastic_below(deck: Any) -> float:
    """The temperature below which collisions lose nothing: that of the deck, or the default before a heated wall."""
    given = deck.gas.elastic_below
    if given is not None:
        return given
    return ELASTIC_BELOW if hasattr(wall_of(deck), "face") else 0.0


def integrator_of(deck: Any, state: State) -> Any:
    """The deck's integrator, ready for `state`."""
    kind = INTEGRATORS[deck.time.integrator]
    return kind(state.gas, wall_of(deck), state.mesh, terms_of(deck), **kind.options(deck))
