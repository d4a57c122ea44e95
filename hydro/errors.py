"""What can go wrong, and the exit code that each kind of trouble has on the command line."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass


class HydroError(Exception):
    """Base of every error that a user can cause or meet; shown without a traceback."""

    exit_code = 3


class RunFailed(HydroError):
    """A run could not go on; the last good state is saved (exit code 3).

    remedy: what a restart must change to get further.
    """

    def __init__(self, message: str, remedy: str = ""):
        super().__init__(message)
        self.remedy = remedy


class NoStep(RunFailed):
    """No step is possible from here, and so none would be after a restart."""


class StepRejected(Exception):
    """A step would leave the admissible states, and where; the state is as it was before."""


class Stopped(HydroError):
    """A signal asked the run to stop; its state is saved (exit code 4)."""

    exit_code = 4


class Missed(HydroError):
    """A study ran and did not find what its deck expects (exit code 5)."""

    exit_code = 5


@dataclass(frozen=True)
class Complaint:
    """One thing wrong with a deck: which key, its value, what is allowed, the nearest known name."""

    key: str
    problem: str
    value: object = None
    nearest: str | None = None

    def __str__(self) -> str:
        hint = f" (did you mean {self.nearest!r}?)" if self.nearest else ""
        return f"{self.key or '(empty)'}: {self.problem}{hint}"


class DeckError(HydroError):
    """A deck or a command-line argument is not valid (exit code 2). Lists every complaint at once."""

    exit_code = 2

    def __init__(self, complaints: list[Complaint] | str, source: str = "deck"):
        if isinstance(complaints, str):
            self.complaints = [Complaint(source, complaints)]
            super().__init__(f"{source}: {complaints}")
            return
        self.complaints = complaints
        lines = "\n".join(f"  {complaint}" for complaint in complaints)
        count = "1 error" if len(self.complaints) == 1 else f"{len(self.complaints)} errors"
        super().__init__(f"{source}: {count}\n{lines}")


class NotInstalled(HydroError):
    """A package is needed that does not come with a plain installation (exit code 2)."""

    exit_code = 2


@contextlib.contextmanager
def extra(name: str, purpose: str) -> Iterator[None]:
    """Around imports of optional packages: NotInstalled, which names the extra that brings them, if one is missing."""
    try:
        yield
    except ModuleNotFoundError as error:
        raise NotInstalled(
            f"{purpose} needs {error.name}, which is not installed: pip install 'hydro[{name}]'"
        ) from None


class CheckpointError(HydroError):
    """A checkpoint cannot be read: missing, damaged, or of the wrong shape (exit code 2)."""

    exit_code = 2
