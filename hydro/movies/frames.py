"""Frames of a movie: the density on a cadence of its own, one small file each, whole or not there.

A frame's file is called after its time: t12.5.h5.
"""

from __future__ import annotations

import io
from pathlib import Path

import h5py
import numpy as np

from hydro.errors import CheckpointError
from hydro.output.files import write_bytes
from hydro.state import State

FORMAT = "hydro frame"


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
