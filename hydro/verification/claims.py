"""What is claimed of the solvers, and how a measurement of it is written down.

    Claim        one statement with its measured value and its bound
    Table        numbers behind claims
    Findings     the tables and claims that one measurement gives
    MEASUREMENTS every measurement, in the order of the book

Modules of the package enter their measurements with the decorator `measurement`.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Literal

from hydro.errors import StepRejected

Comparison = Literal["<=", ">="]
Row = Sequence[float | int | str]


@dataclass(frozen=True)
class Claim:
    """A statement that holds when `measured` is on the right side of `bound`; words in place of a number fail."""

    topic: str
    statement: str
    expected: str
    measured: float | str
    bound: float
    comparison: Comparison = "<="

    @property
    def passed(self) -> bool:
        if isinstance(self.measured, str):
            return False
        return bool(self.measured <= self.bound if self.comparison == "<=" else self.measured >= self.bound)

    def __str__(self) -> str:
        verdict = "holds" if self.passed else "FAILS"
        wanted = f"wanted {self.comparison} {self.bound:.3g}"
        return f"{verdict}: {self.statement}: measured {number(self.measured)}, {wanted} ({self.expected})"


def at_most(topic: str, statement: str, expected: str, measured: float, bound: float) -> Claim:
    """The claim that `measured` does not exceed `bound`."""
    return Claim(topic, statement, expected, measured, bound, "<=")


def at_least(topic: str, statement: str, expected: str, measured: float, bound: float) -> Claim:
    """The claim that `measured` reaches `bound`."""
    return Claim(topic, statement, expected, measured, bound, ">=")


@dataclass(frozen=True)
class Table:
    """Rows of numbers and words under a header."""

    caption: str
    header: Sequence[str]
    rows: Sequence[Row]


@dataclass(frozen=True)
class Findings:
    """What a measurement gives; findings add up."""

    claims: tuple[Claim, ...] = ()
    tables: tuple[Table, ...] = ()

    def __add__(self, other: Findings) -> Findings:
        return Findings(self.claims + other.claims, self.tables + other.tables)


@dataclass(frozen=True)
class Measurement:
    """A function of `full` (the longer version, or the quick one) with its place in the book.

    Its docstring tells the reader what is measured and how; that of its module opens the chapter.
    """

    topic: str
    title: str
    function: Callable[[bool], Findings] = field(repr=False)

    @property
    def explanation(self) -> str:
        return inspect.getdoc(self.function) or ""

    @property
    def introduction(self) -> str:
        return inspect.getdoc(sys.modules[self.function.__module__]) or ""

    def findings(self, full: bool) -> Findings:
        """Measure; a run that breaks down is a failed claim."""
        try:
            return self.function(full)
        except StepRejected:
            words = "a step left 0 < n < 1, T > 0"
            return Findings((Claim(self.topic, self.title, "every run reaches its end", words, 0.0),))


MEASUREMENTS: list[Measurement] = []


def measurement(topic: str, title: str) -> Callable[[Callable[[bool], Findings]], Callable[[bool], Findings]]:
    """Decorator that enters a function into MEASUREMENTS."""

    def enter(function: Callable[[bool], Findings]) -> Callable[[bool], Findings]:
        MEASUREMENTS.append(Measurement(topic, title, function))
        return function

    return enter


def topics() -> Iterator[tuple[str, list[Measurement]]]:
    """The topics in order, each with its measurements."""
    for topic in dict.fromkeys(measurement.topic for measurement in MEASUREMENTS):
        yield topic, [measurement for measurement in MEASUREMENTS if measurement.topic == topic]


def number(value: float | int | str) -> str:
    """A number as the book prints it."""
    return f"{value:.3g}" if isinstance(value, float) else str(value)
