"""Frames of a movie: the density on a cadence of its own, one small file each, whole or not there.

A frame's file is called after its time: t12.5.h5.
"""

from __future__ import annotations

import io
import math
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np

from hydro.driver.march import Run
from hydro.driver.trackers import Quiet, multiple_after
from hydro.errors import CheckpointError
from hydro.output.files import write_bytes
from hydro.state import State

FORMAT = "hydro frame"


class Frames(Quiet):
    """Keeps a frame of the first step after each interval, and of the last: of the state that `seen` gives of a run.

    Goes on after the frames that the folder holds; those later than `begin`, the time of the first look, are removed.
    """

    def __init__(self, folder: Path, interval: float, begin: float, seen: Callable[[Run], State]):
        self.folder, self.interval, self.seen = folder, interval, seen
        folder.mkdir(exist_ok=True)
        forget_after(folder, begin)
        self._due = multiple_after(max(map(frame_time, frames(folder)), default=-math.inf), interval)

    def look(self, run: Run) -> None:
        now = run.state.time
        if now >= self._due or now >= run.end:
            write_frame(self.folder, self.seen(run))
            self._due = multiple_after(now, self.interval)


def write_frame(folder: Path, state: State) -> None:
    """Write the density of `state`, whole or not at all."""
    path = folder / f"t{float(state.time)!r}.h5"
    image = io.BytesIO()
    with h5py.File(image, "w") as file:
        file.attrs.update(format=FORMAT, time=state.time, time_unit="L_x/T_*^(1/2)")
        shown = state.density.T.astype(np.float32)
        density = file.create_dataset("density", data=shown, compression="gzip", shuffle=True, fletcher32=True)
        density.attrs.update(long_name="number density", units="n_c")
    write_bytes(path, image.getvalue())


def read_frame(path: Path) -> np.ndarray:
    """The density of a frame, shape (nx, ny); CheckpointError if the file cannot be read."""
    try:
        with h5py.File(path, "r") as file:
            return file["density"][:].T
    except (OSError, KeyError, ValueError, TypeError, RuntimeError) as error:
        raise CheckpointError(f"{path}: not a readable frame ({error})") from error


def frames(folder: Path) -> list[Path]:
    """The frames in a folder, in order of time."""
    return sorted(folder.glob("t*.h5"), key=frame_time)


def frame_time(path: Path) -> float:
    """The time of a frame, from the name of its file."""
    return float(path.stem.removeprefix("t"))


def forget_after(folder: Path, time: float) -> None:
    """Remove the frames later than `time`, to which a run goes back."""
    for path in frames(folder):
        if frame_time(path) > time:
            path.unlink()
