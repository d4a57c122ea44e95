"""Named sets of observables: the numbers that describe a state, and where each of them is shown.

A set belongs to a problem, such as clustering before a driving wall. Summary, history, checkpoints, closing lines,
pictures, comparisons and reports ask the set of a deck; none of them knows a name of its own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from hydro.choices import OBSERVABLES
from hydro.mesh import Mesh
from hydro.state import State

Row = dict[str, Any]


class Quantity(NamedTuple):
    """A number that describes a state.

    name: in files. of: computes it from a state and the law of the driving wall. label: in tables. average: computes it
    from the fields of grains averaged over looks, in which cells may be empty; without it, `of` does.
    """

    name: str
    long_name: str
    unit: str
    of: Callable[[State, Any], float]
    label: str = ""
    average: Callable[[State, Any], float] | None = None

    def averaged(self, state: State, wall: Any) -> float:
        """Of an average over looks at grains."""
        return (self.average or self.of)(state, wall)


class Curve(NamedTuple):
    """A quantity against time: its name in the history, its words in a legend, how its line is dashed."""

    column: str
    legend: str = ""
    dash: str = "-"


class Panel(NamedTuple):
    """Curves that share an axis: what it shows, its label, its relative height and its scale."""

    words: str
    label: str
    curves: tuple[Curve, ...]
    height: int = 1
    scale: str = "log"


class Span(NamedTuple):
    """The smallest and the largest density that maps and movies tell.

    label: what they are of, in a picture. words: the same in a sentence. of: computes both from a density (nx, ny) on
    its mesh. curves: the columns of the history that have them, if any, the largest first.
    """

    label: str
    words: str
    of: Callable[[np.ndarray, Mesh], tuple[float, float]]
    curves: tuple[Curve, ...] = ()

    def note(self, density: np.ndarray, mesh: Mesh) -> str:
        """What stands under a map."""
        low, high = self.of(density, mesh)
        return f"{self.label}: {low:.3g} to {high:.3g}"


@dataclass(frozen=True)
class Observables:
    """A named set.

    fits: whether it is for the problem of a deck. summary: what summary and history say of a state, in this order.
    history: what only the history says. energies: of those, mass and energies, beside the ledger. estimated: of
    averages over grains, those told with a standard error; averages: further ones of averages alone. closing: names,
    words and formats in closing lines. compared: what `compare` and reports tell. drifting: whose change tells how far
    a run is from rest. panels: pictures of the history. overlaid: panels for several runs. span: of maps and movies.
    drawn: further pictures of states, by their names in `hydro.choices.STATE_PICTURES`.
    """

    name: str
    fits: Callable[[Any], bool]
    summary: tuple[Quantity, ...]
    history: tuple[Quantity, ...]
    energies: tuple[Quantity, ...]
    estimated: tuple[Quantity, ...]
    averages: tuple[Quantity, ...]
    closing: tuple[tuple[str, str, str], ...]
    compared: tuple[Quantity, ...]
    drifting: tuple[str, ...]
    panels: tuple[Panel, ...]
    overlaid: tuple[Panel, ...]
    span: Span
    drawn: tuple[str, ...] = ()

    @property
    def quantities(self) -> dict[str, Quantity]:
        """All of them, by name."""
        groups = (self.summary, self.estimated, self.averages, self.history, self.energies, self.compared)
        return {each.name: each for group in groups for each in group}

    @property
    def words(self) -> dict[str, tuple[str, str]]:
        """Long name and unit by name, those of standard errors included."""
        words = {name: (each.long_name, each.unit) for name, each in self.quantities.items()}
        errors = {error_of(each.name): (f"standard error of {each.name}", each.unit) for each in self.estimated}
        return words | errors

    def label(self, name: str) -> str:
        """What a table calls a quantity."""
        known = self.quantities.get(name)
        return known.label or known.long_name if known else name

    def drift(self, snapshots: list[Row]) -> float | None:
        """How fast a run still changes: the largest of |d log q/dt| between the last two snapshots."""
        if len(snapshots) < 2 or not self.drifting:
            return None
        before, after = snapshots[-2:]
        changes = [abs(math.log(after[key] / before[key])) for key in self.drifting]
        return max(changes) / (after["time"] - before["time"])

    def snapshot(self, state: State, wall: Any) -> Row:
        """What the summary says of a state."""
        return values(self.summary, state, wall)

    def closing_line(self, row: Row) -> str:
        """A snapshot in a line; if it has standard errors, only what has one, with it."""
        with_errors = any(error_of(name) in row for name, _, _ in self.closing)
        told = [
            f"{words} {with_error(row, name, form)}"
            for name, words, form in self.closing
            if not with_errors or error_of(name) in row
        ]
        return f"t={row['time']:<8g} {'  '.join(told)}"


def observables_of(deck: Any) -> Observables:
    """The set for the problem of a deck: of those that fit, the one that comes last."""
    return [each for _, each in OBSERVABLES.items() if each.fits(deck)][-1]


def observables_in(result: Mapping[str, Any]) -> Observables:
    """The set that a summary, or another result, names; that of clusters where a version before 0.2 names none."""
    return OBSERVABLES[result.get("observables", "clustering")]


def values(quantities: tuple[Quantity, ...], state: State, wall: Any) -> Row:
    """Quantities of a state, by name."""
    return {each.name: each.of(state, wall) for each in quantities}


def error_of(name: str) -> str:
    """What the standard error of a quantity is called."""
    return f"{name}_error"


def with_error(row: Row, name: str, form: str) -> str:
    """A number of a row, and its standard error where it is known."""
    error = row.get(error_of(name))
    known = error is not None and math.isfinite(error)
    return f"{row[name]:{form}} ± {error:{form}}" if known else f"{row[name]:{form}}"
