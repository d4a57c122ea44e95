"""Where members run: on processes of this machine, or on a Dask cluster whose scheduler has an address.

Only text goes to a worker and comes back: a deck, names of folders, a summary. Its processes have this package, and see
the folders under the same names.
"""

from __future__ import annotations

import contextlib
import logging
import os
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict

from hydro.deck import parse
from hydro.errors import DeckError, HydroError, extra
from hydro.output.folder import RunFolder
from hydro.studies.members import chained, run_member

if TYPE_CHECKING:
    from distributed import Client

PATIENCE = "10s"  # until a scheduler answers
ONE_AT_A_TIME = threading.Lock()  # in a worker with several threads: neither kernels nor pictures run side by side


class Outcome(TypedDict):
    """What has become of a member."""

    completed: bool
    summary: dict[str, Any] | None
    error: str | None


class Start(TypedDict):
    """How a member of a chain starts: from the last state in the folder of the one before, perturbed."""

    folder: str
    perturbation: dict[str, Any] | None


@contextlib.contextmanager
def client_of(scheduler: str | None, members: int) -> Iterator[Client]:
    """A client of the scheduler at an address, or else of as many processes here as there are cores and members.

    DeckError if nobody answers at the address; NotInstalled without Dask.
    """
    with extra("dask", "a sweep"):
        from distributed import Client, LocalCluster  # slow to import

    with contextlib.ExitStack() as stack:
        if scheduler is None:
            count = min(len(os.sched_getaffinity(0)), members)
            cluster = LocalCluster(
                n_workers=count, threads_per_worker=1, processes=True, memory_limit=0, dashboard_address=":0",
                silence_logs=logging.CRITICAL,
            )  # fmt: skip
            yield stack.enter_context(Client(stack.enter_context(cluster), set_as_default=False))
            return
        try:
            client = Client(scheduler, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError) as error:
            raise DeckError(f"no Dask scheduler answers at {scheduler!r} ({error})", "--scheduler") from None
        yield stack.enter_context(client)


def work(text: str, folder: str, start: Start | None = None, before: Outcome | None = None) -> Outcome:
    """Run one member on a worker, on one thread.

    text: the deck, resolved. start, before: how it starts from another member, and what has become of that.
    """
    import numba

    numba.set_num_threads(1)
    if before is not None and not before["completed"]:
        return Outcome(completed=False, summary=None, error="the member that it starts from is not completed")
    with ONE_AT_A_TIME:
        try:
            deck = parse(text)
            if start is not None:
                deck = chained(deck, **start)
            summary = run_member(deck, RunFolder(Path(folder)))
        except (HydroError, OSError, MemoryError) as error:
            return Outcome(completed=False, summary=None, error=str(error) or type(error).__name__)
    return Outcome(completed=True, summary=summary, error=None)


def outcomes(client: Client, futures: dict[Any, int]) -> Iterator[tuple[int, Outcome]]:
    """Numbers of members and what has become of them, as they finish. `futures`: their numbers by future."""
    from distributed import as_completed

    for future in as_completed(list(futures), loop=client.loop):
        failure = future.exception() if future.status == "error" else None
        if failure is not None:
            yield futures[future], Outcome(completed=False, summary=None, error=f"{type(failure).__name__}: {failure}")
        elif future.cancelled():
            yield futures[future], Outcome(completed=False, summary=None, error="the scheduler has gone")
        else:
            yield futures[future], future.result()
