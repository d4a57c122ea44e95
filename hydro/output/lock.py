"""One process at a time in a folder."""

from __future__ import annotations

import contextlib
import fcntl
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TextIO

from hydro.errors import DeckError


@contextlib.contextmanager
def locked(path: Path) -> Iterator[None]:
    """Hold the lock on the file `path`, which is made, within the block; DeckError if another process holds it.

    The lock is the operating system's (flock), so that nothing of it is left when a process is killed.
    """
    with path.open("a+", encoding="utf-8") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise DeckError(f"{path.parent}: {_holder(file)} is at work there", "output folder") from None
        except OSError as error:
            print(f"hydro: no lock ({error.strerror}): start nothing else in {path.parent}", file=sys.stderr)
        if not os.path.samestat(os.fstat(file.fileno()), path.stat()):
            raise DeckError(f"{path.parent} has just been removed by another process", "output folder")
        file.truncate(0)
        file.write(f"process {os.getpid()} on {os.uname().nodename}\n")
        file.flush()
        yield


def _holder(file: TextIO) -> str:
    file.seek(0)
    return file.readline().strip() or "another process"
