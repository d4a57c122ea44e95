"""`kind = "convergence"` and `kind = "sweep"`: studies that run a base deck many times, some of its keys changed."""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Callable, Sequence
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, ValidationInfo, field_validator

from hydro.choices import INITIAL_STATES, KINDS, PATTERNS, REFERENCES
from hydro.deck.sections import Deck, Range
from hydro.registry import nearest
from hydro.schema import Chosen, Flag, ListOr, Named, Positive, Section, Text, broken_rule, distinct

MOST_MEMBERS = 100_000

Changes = dict[str, Any]  # of a base deck: values by dotted key


class Variation(Section):
    """Keys of the base deck that change together."""

    keys: tuple[Text, ...] = Field(min_length=1, description="dotted keys of the base deck")
    values: Annotated[tuple[Any, ...] | Range, ListOr(Range)] = Field(
        description="values of the key; with several keys a list of lists, each with one value for every key"
    )

    @field_validator("keys")
    @classmethod
    def _check_keys(cls, keys: tuple[str, ...]) -> tuple[str, ...]:
        return distinct(keys)

    @field_validator("values")
    @classmethod
    def _check_values(cls, values: tuple[Any, ...] | Range, info: ValidationInfo) -> tuple[Any, ...] | Range:
        count = len(info.data.get("keys", ()))
        rows = values if isinstance(values, tuple) else ()
        if rows == values == ():
            raise broken_rule("must have an item")
        if count > 1 and not (rows and all(isinstance(row, list | tuple) and len(row) == count for row in rows)):
            raise broken_rule(f"must be lists of {count} values, one for each of the keys")
        return values

    @property
    def changes(self) -> list[Changes]:
        """What to change in the base deck, one time after the other."""
        values: tuple[Any, ...] = self.values.values if isinstance(self.values, Range) else self.values
        rows = [(value,) for value in values] if len(self.keys) == 1 else values
        return [dict(zip(self.keys, row, strict=True)) for row in rows]


def combinations(variations: Sequence[Variation]) -> list[Changes]:
    """The product of variations, the last one changing fastest; of none, one that changes nothing."""
    product = itertools.product(*(variation.changes for variation in variations))
    return [{key: value for part in parts for key, value in part.items()} for parts in product]


def check_variations(variations: Sequence[Variation], key: str) -> None:
    """Refuses variations of one key at the same time, and too many combinations."""
    keys = [name for variation in variations for name in variation.keys]
    if len(set(keys)) < len(keys):
        raise broken_rule("two variations must not change the same key", key, keys)
    count = math.prod(len(variation.changes) for variation in variations)
    if count > MOST_MEMBERS:
        raise broken_rule(f"must give {MOST_MEMBERS} combinations or less", key, count)


def check_scalars(names: tuple[str, ...], base: Deck | None, key: str) -> None:
    """Refuses names of numbers that the base deck does not give, and repetitions."""
    for name in names:
        if base is not None and name not in base.scalars:
            close = nearest(name, base.scalars)
            hint = f"; did you mean {close!r}?" if close else ""
            raise broken_rule(f"known for kind {base.kind!r}: {', '.join(base.scalars)}{hint}", key, name)
    if len(set(names)) < len(names):
        raise broken_rule("must not repeat an item", key, names)


def check_exact(base: Any) -> None:
    """Refuses a base deck whose evolution is not exactly known."""
    if base.kind != "evolution":
        raise broken_rule("must be 'evolution' for an exact reference", "base.kind", base.kind)
    needed = base.initial.exact_if
    if needed is None:
        known = [name for name, state in INITIAL_STATES.items() if state.exact_if is not None]
        raise broken_rule(
            f"must have an exact evolution; known: {', '.join(known)}", "base.initial.kind", base.initial.kind
        )
    for condition in needed:
        if not condition.holds(base):
            problem = f"the exact evolution from {base.initial.kind!r} needs more: {condition.key} {condition.words}"
            raise broken_rule(problem, f"base.{condition.key}")


def grid_sizes(cells: list[Any]) -> list[float]:
    """Cell widths along x, or along y where only that changes, for a box of length one."""
    axis = 0 if cells[0][0] != cells[-1][0] else 1
    return [1.0 / count[axis] for count in cells]


# What orders are taken in: the first of these keys that the ladder has. The error of a step is proportional to its
# square, and the tolerance bounds that.
SIZES: dict[str, Callable[[list[Any]], list[float]]] = {
    "mesh.cells": grid_sizes,
    "time.dt_max": lambda steps: [float(step) for step in steps],
    "time.cfl": lambda shares: [float(share) for share in shares],
    "time.tolerance": lambda tolerances: [math.sqrt(tolerance) for tolerance in tolerances],
}


def ladder_sizes(ladder: Variation) -> list[float]:
    """Cell widths, or time steps, of the levels, up to a common factor."""
    key = next(key for key in SIZES if key in ladder.keys)
    return SIZES[key]([changes[key] for changes in ladder.changes])


class Convergence(Section):
    """Grids and steps, and what to measure on them."""

    ladder: Variation = Field(
        description="the levels, coarse to fine: grids (mesh.cells), "
        "steps (time.dt_max, time.cfl, time.tolerance) or both"
    )
    variants: tuple[Variation, ...] = Field(
        default=(), description="what to repeat the ladder for, in all combinations: integrators, for example"
    )
    reference: Annotated[Text, Named(REFERENCES)] = Field(
        default="next",
        description="what errors are taken against: the exact evolution from the initial state, the finest level, or "
        "the next finer one",
    )
    scalars: tuple[Text, ...] = Field(default=(), description="numbers of a run whose limits are wanted")
    order: Positive = Field(default=2.0, description="order of the method, for the limits")

    @field_validator("ladder")
    @classmethod
    def _check_ladder(cls, ladder: Variation) -> Variation:
        if len(ladder.changes) < 2:
            raise broken_rule("must have two levels or more")
        if not set(SIZES) & set(ladder.keys):
            raise broken_rule(f"its keys must have one of {', '.join(SIZES)}")
        sizes: list[float] = []
        with contextlib.suppress(TypeError, ValueError, IndexError, ArithmeticError):  # the runs' decks will complain
            sizes = ladder_sizes(ladder)
        if any(fine >= coarse for coarse, fine in itertools.pairwise(sizes)):
            raise broken_rule("must go from coarse to fine")
        return ladder

    @property
    def sizes(self) -> list[float]:
        """Cell widths, or time steps, of the levels, up to a common factor."""
        return ladder_sizes(self.ladder)


class Expect(Section):
    """What the study must find, else it ends with exit code 5. Nothing is expected by default."""

    order: Positive | None = Field(
        default=None, description="least order of the sum of the errors, between the two finest levels that have errors"
    )
    limit_error: Positive | None = Field(
        default=None, description="largest error bar of a limit, relative to the limit"
    )


class ConvergenceDeck(Deck):
    """Errors of a base deck on a ladder of grids and steps, their orders, and limits of scalars."""

    scalars: ClassVar[tuple[str, ...]] = ("order", "limit", "limit_error")

    kind: Literal["convergence"] = "convergence"
    base: Annotated[Deck, Chosen(KINDS, only=("evolution", "steady"))] = Field(
        description="The deck to study: a file beside this deck, or a section with its keys; "
        "in a section, `deck` may name a file that the other keys change"
    )
    convergence: Convergence
    expect: Expect = Expect()

    @field_validator("convergence")
    @classmethod
    def _check_convergence(cls, convergence: Convergence, info: ValidationInfo) -> Convergence:
        base = info.data.get("base")
        check_variations((*convergence.variants, convergence.ladder), "convergence.variants")
        check_scalars(convergence.scalars, base, "convergence.scalars")
        if base is not None and convergence.reference == "exact":
            check_exact(base)
        return convergence

    @property
    def changes(self) -> list[Changes]:
        """What to change in the base deck for every run: variant by variant, the levels in turn."""
        return combinations((*self.convergence.variants, self.convergence.ladder))


class Sweep(Section):
    """What to vary."""

    axes: tuple[Variation, ...] = Field(
        min_length=1, description="what to vary, in all combinations, the last one changing fastest"
    )
    chain: Flag = Field(
        default=False,
        description="whether a member starts from the last state of the one before along the last axis, its density "
        "changed to gas.f: for hysteresis",
    )
    perturbation: Annotated[Any | None, Chosen(PATTERNS)] = Field(
        default=None, description="Relative change of the density with which the members of a chain start"
    )
    draw: tuple[Text, ...] = Field(
        default=(), description="numbers of a run to draw; the first in the table when none are named"
    )

    @field_validator("perturbation")
    @classmethod
    def _check_perturbation(cls, perturbation: Any, info: ValidationInfo) -> Any:
        if perturbation is not None and not info.data.get("chain", True):
            raise broken_rule("only the members of a chain are perturbed: set sweep.chain")
        return perturbation


class SweepDeck(Deck):
    """Runs of a base deck with some of its keys varied, on the cores of this machine or on a cluster."""

    kind: Literal["sweep"] = "sweep"
    base: Annotated[Deck, Chosen(KINDS, only=tuple(kind for kind in KINDS if kind != "sweep"))] = Field(
        description="The deck to vary: a file beside this deck, or a section with its keys; "
        "in a section, `deck` may name a file that the other keys change"
    )
    sweep: Sweep

    @field_validator("sweep")
    @classmethod
    def _check_sweep(cls, sweep: Sweep, info: ValidationInfo) -> Sweep:
        base = info.data.get("base")
        check_variations(sweep.axes, "sweep.axes")
        check_scalars(sweep.draw, base, "sweep.draw")
        if base is not None and sweep.chain and base.kind != "evolution":
            raise broken_rule("must be 'evolution' for a chain", "base.kind", base.kind)
        return sweep

    @property
    def changes(self) -> list[Changes]:
        """What to change in the base deck for every member."""
        return combinations(self.sweep.axes)
