"""Progress of work that is no run in time: items whose number is known, or points until there are no more."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from typing import TypeVar

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

T = TypeVar("T")


def legible(rate: float) -> str:
    """A rate in digits: 2.5, 48, 1,430,000."""
    return f"{rate:,.0f}" if rate >= 10.0 else f"{rate:.2g}"


def counted(items: Sequence[T], title: str, quiet: bool) -> Iterator[T]:
    """The items one by one; on stderr a bar if that is a terminal, else a line for every tenth; neither when quiet."""
    yield from expected(items, len(items), title, quiet)


def expected(items: Iterable[T], count: int, title: str, quiet: bool) -> Iterator[T]:
    """As `counted`, for items that come one by one, `count` of them."""
    if quiet:
        yield from items
    elif sys.stderr.isatty():
        yield from _with_bar(items, count, title)
    else:
        yield from _with_lines(items, count, title)


def _with_bar(items: Iterable[T], count: int, title: str) -> Iterator[T]:
    columns = (
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[rate]}"),
        TimeRemainingColumn(),
    )  # fmt: skip
    started = time.perf_counter()
    with Progress(*columns, console=Console(stderr=True)) as progress:
        task = progress.add_task(title, total=count, rate="")
        for done, item in enumerate(items, start=1):
            yield item
            rate = done / (time.perf_counter() - started)
            progress.update(task, completed=done, rate=f"{legible(rate)} a second")


def _with_lines(items: Iterable[T], count: int, title: str) -> Iterator[T]:
    started, due = time.perf_counter(), 0.1
    for done, item in enumerate(items, start=1):
        yield item
        share = done / count
        if share >= due:
            rate = done / (time.perf_counter() - started)
            left = (count - done) / rate
            print(f"{title}: {share:4.0%}  {legible(rate)} a second  {left:.0f} s left", file=sys.stderr, flush=True)
            due = math.floor(share * 10.0 + 1.0) / 10.0


class Tally:
    """A line every few seconds on work of unknown length."""

    INTERVAL = 2.0  # seconds

    def __init__(self, title: str, quiet: bool):
        self.title, self.quiet = title, quiet
        self.count, self._started = 0, time.perf_counter()
        self._due = self._started + self.INTERVAL

    def add(self, where: str) -> None:
        """One more is done."""
        self.count += 1
        now = time.perf_counter()
        if self.quiet or now < self._due:
            return
        self._due = now + self.INTERVAL
        rate = self.count / (now - self._started)
        print(f"{self.title}: {self.count} points, {legible(rate)} a second, {where}", file=sys.stderr, flush=True)
