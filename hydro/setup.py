"""From a deck to the things it names: gas, mesh, wall."""

from __future__ import annotations

from hydro.deck import model
from hydro.gas import CLOSURES, Closure
from hydro.mesh import Mesh
from hydro.walls import WALLS


def gas_of(deck: model.EvolutionDeck) -> Closure:
    """The closure named by the deck, with its constants."""
    return CLOSURES[deck.gas.closure](L=deck.gas.L, K=deck.gas.K, alpha=deck.gas.alpha)


def mesh_of(deck: model.EvolutionDeck) -> Mesh:
    """The deck's mesh."""
    periodic = ("x" in deck.box.periodic, "y" in deck.box.periodic)
    return Mesh.rectangle(deck.mesh.cells, deck.box.aspect_ratio, deck.mesh.stretch, periodic)


def wall_of(deck: model.EvolutionDeck):
    """The law of the driving wall; its parameters are the keys of the section beside `kind`."""
    return WALLS[deck.wall.kind](**deck.wall.model_dump(exclude={"kind"}))
