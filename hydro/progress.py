"""How far work has got: on stderr a bar if that is a terminal, else a line for every tenth; nothing when quiet."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from typing import Protocol, Self, TypeVar

T = TypeVar("T")


def legible(rate: float) -> str:
    """A rate in digits: 2.5, 48, 1,430,000."""
    return f"{rate:,.0f}" if rate >= 10.0 else f"{rate:.2g}"


class Progress(Protocol):
    """Shows how much of `total` is done. A context manager."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        return None

    def show(self, done: float, words: str) -> None:
        """So much is done; `words` say more."""
        return None


def progress(title: str, total: float, quiet: bool, begun: float = 0.0) -> Progress:
    """What shows progress here; `begun` of the total is done already."""
    if quiet or not total:
        return Silence()
    return (Bar if sys.stderr.isatty() else Lines)(title, total, begun)


class Silence(Progress):
    """Shows nothing."""


class Bar(Progress):
    """A bar with the time left."""

    INTERVAL = 0.2  # seconds between updates

    def __init__(self, title: str, total: float, begun: float):
        from rich.console import Console  # slow to import
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

        columns = (
            TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TextColumn("{task.fields[words]}"),
            TimeRemainingColumn(),
        )  # fmt: skip
        self._total, self._bar = total, Progress(*columns, console=Console(stderr=True))
        self._task = self._bar.add_task(title, total=total, words="")
        self._bar.update(self._task, completed=begun)
        self._due = 0.0

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()

    def show(self, done: float, words: str) -> None:
        now = time.perf_counter()
        if now >= self._due or done >= self._total:
            self._due = now + self.INTERVAL
            self._bar.update(self._task, completed=done, words=words)


class Lines(Progress):
    """A line for every tenth."""

    def __init__(self, title: str, total: float, begun: float):
        self.title, self.total, self.begun = title, total, begun
        self._started, self._due = time.perf_counter(), self._after(begun / total)

    def show(self, done: float, words: str) -> None:
        share = done / self.total
        if share < self._due:
            return
        left = (time.perf_counter() - self._started) * (self.total - done) / (done - self.begun)
        print(f"{self.title}: {share:4.0%}  {words}  {left:.0f} s left", file=sys.stderr, flush=True)
        self._due = self._after(share)

    @staticmethod
    def _after(share: float) -> float:
        """The next tenth."""
        return math.floor(share * 10.0 + 1.0) / 10.0


def counted(items: Sequence[T], title: str, quiet: bool) -> Iterator[T]:
    """The items one by one, and on stderr how many are done and how fast."""
    yield from expected(items, len(items), title, quiet)


def expected(items: Iterable[T], count: int, title: str, quiet: bool) -> Iterator[T]:
    """As `counted`, for items that come one by one, `count` of them."""
    started = time.perf_counter()
    with progress(title, count, quiet) as shown:
        for done, item in enumerate(items, start=1):
            yield item
            shown.show(done, f"{done}/{count}  {legible(done / (time.perf_counter() - started))} a second")


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
