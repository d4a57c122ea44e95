"""What the levels of a study of convergence are measured against."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from hydro.choices import REFERENCES
from hydro.deck import Deck
from hydro.errors import Complaint, DeckError
from hydro.mesh import Mesh
from hydro.output.checkpoint import FIELDS, Checkpoint

NAMES = tuple(name for name, _, _ in FIELDS)
TOTAL = "total"


class Level(NamedTuple):
    """A run of the ladder: its deck and the state that it ends in."""

    deck: Deck
    end: Checkpoint


def errors(levels: Sequence[Level], reference: str) -> list[dict[str, float | None]]:
    """For every level the means over the box of |error| of the conserved fields, by name, and their sum."""
    found: list[dict[str, float | None]] = []
    for k, level in enumerate(levels):
        wanted = REFERENCES[reference](levels, k)
        if wanted is None:
            found.append(dict.fromkeys((*NAMES, TOTAL)))
            continue
        mesh = level.end.mesh
        means = [mesh.integral(np.abs(part)) / mesh.aspect_ratio for part in level.end.conserved - wanted]
        found.append({**dict(zip(NAMES, means, strict=True)), TOTAL: sum(means)})
    return found


def exact(levels: Sequence[Level], k: int) -> np.ndarray | None:
    """The exact evolution from the initial state."""
    deck, end = levels[k]
    initial: Any = deck.initial  # type: ignore[attr-defined]
    return initial.evolution(deck)(end.mesh, end.time)


def finest(levels: Sequence[Level], k: int) -> np.ndarray | None:
    """The last level."""
    return averages(levels[-1].end, levels[k].end.mesh) if k < len(levels) - 1 else None


def following(levels: Sequence[Level], k: int) -> np.ndarray | None:
    """The next finer level."""
    return averages(levels[k + 1].end, levels[k].end.mesh) if k < len(levels) - 1 else None


def averages(fine: Checkpoint, mesh: Mesh) -> np.ndarray:
    """The conserved fields of a state on a finer mesh, averaged over the cells of `mesh`: (4, nx, ny)."""
    (nx, ny), areas = mesh.cells, fine.mesh.areas
    blocks = (nx, areas.shape[0] // nx, ny, areas.shape[1] // ny)
    sums = (fine.conserved * areas).reshape(4, *blocks).sum(axis=(2, 4))
    return sums / areas.reshape(blocks).sum(axis=(1, 3))


def check_nested(decks: Sequence[Deck], reference: str) -> None:
    """DeckError if levels are to be compared whose cells do not lie in each other's."""
    if reference == "exact":
        return
    cells = [deck.mesh.cells for deck in decks]  # type: ignore[attr-defined]
    for coarse, fine in pairwise(cells):
        if any(many % few for few, many in zip(coarse, fine, strict=True)):
            problem = f"mesh.cells = {list(fine)} must be multiples of {list(coarse)}, for {reference!r} as reference"
            raise DeckError([Complaint("convergence.ladder", problem)])
