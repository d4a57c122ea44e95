"""Checkpoints: everything that is needed to look at a state, or to go on from it, in one HDF5 file."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

import hydro
from hydro.errors import CheckpointError
from hydro.mesh import Mesh
from hydro.runs.files import replacing
from hydro.state import State

FORMAT = "hydro checkpoint"
VERSION = 2

# Name, long name and unit of the conserved fields, in the order of the state. In the file x varies fastest, as other
# programs expect it of a mesh: datasets have the shape (ny, nx).
FIELDS = (
    ("density", "number density", "n_c"),
    ("momentum_x", "momentum density along x", "n_c T_*^(1/2)"),
    ("momentum_y", "momentum density along y", "n_c T_*^(1/2)"),
    ("energy", "granular and flow energy density", "n_c T_*"),
)
FACES = (("x_faces", "cell faces in x"), ("y_faces", "cell faces in y"))


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """A saved moment of a run.

    conserved: (4, nx, ny). ledger: pairs (sum, compensation) by entry, and the initial energy and mass.
    memory: what the integrator remembers. deck: resolved TOML text.
    """

    mesh: Mesh
    conserved: np.ndarray
    time: float
    steps: int
    rejected: int
    dt_limit: float
    ledger: dict[str, tuple[float, float]]
    memory: dict[str, np.ndarray]
    deck: str

    @classmethod
    def of(cls, state: State, deck: str) -> Checkpoint:
        """A state that no run has led to, to start from."""
        return cls(state.mesh, state.conserved, state.time, 0, 0, math.inf, {}, {}, deck)


def write_checkpoint(path: Path, saved: Checkpoint) -> None:
    """Write `saved` to `path`, whole or not at all."""
    with replacing(path) as temporary, h5py.File(temporary, "w") as file:
        file.attrs.update(
            format=FORMAT, format_version=VERSION, hydro_version=hydro.__version__, deck=saved.deck,
            time=saved.time, time_unit="L_x/T_*^(1/2)", steps=saved.steps, rejected_steps=saved.rejected,
            dt_limit=saved.dt_limit, periodic=saved.mesh.periodic,
        )  # fmt: skip
        for (name, long_name, unit), field in zip(FIELDS, saved.conserved, strict=True):
            _dataset(file, name, field.T, long_name, unit)
        for (name, long_name), faces in zip(FACES, (saved.mesh.x_faces, saved.mesh.y_faces), strict=True):
            _dataset(file, name, faces, long_name, "L_x")
        file.create_group("ledger").attrs.update(saved.ledger)
        memory = file.create_group("integrator")
        for name, values in saved.memory.items():
            memory.create_dataset(name, data=values)


def _dataset(file: h5py.File, name: str, values: np.ndarray, long_name: str, unit: str) -> None:
    dataset = file.create_dataset(name, data=values)
    dataset.attrs.update(long_name=long_name, units=unit)


def read_checkpoint(path: Path) -> Checkpoint:
    """Read a checkpoint; CheckpointError says what is wrong with a file that is none."""
    with _opened(path) as file:
        return _read(file)


def read_field(path: Path, name: str) -> np.ndarray:
    """One field of a checkpoint, shape (nx, ny); CheckpointError as of `read_checkpoint`."""
    with _opened(path) as file:
        return file[name][:].T


def read_labels(path: Path) -> dict[str, Any]:
    """Time, steps, program version and whatever else a checkpoint says of itself, without its fields.

    CheckpointError as of `read_checkpoint`.
    """
    with _opened(path) as file:
        return dict(file.attrs)


def checkpoint_times(folder: Path, known: Mapping[Path, float] | None = None) -> tuple[dict[Path, float], list[str]]:
    """Times of the checkpoints in a folder, in order, and what is wrong with those that cannot be read.

    known: times of checkpoints that need not be opened again.
    """
    times, troubles = {}, []
    for path in folder.glob("*.h5"):
        if path.name.startswith("."):
            continue
        try:
            times[path] = known[path] if known and path in known else float(read_labels(path)["time"])
        except CheckpointError as error:
            troubles.append(str(error))
    return dict(sorted(times.items(), key=lambda entry: (entry[1], entry[0]))), troubles


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[h5py.File]:
    """The file of a checkpoint of this version; CheckpointError if it is none, or if reading it fails."""
    try:
        with h5py.File(path, "r") as file:
            if file.attrs.get("format") != FORMAT:
                raise ValueError(f"its format is not {FORMAT!r}")
            if file.attrs["format_version"] != VERSION:
                raise ValueError(f"format version {file.attrs['format_version']}, this program reads {VERSION}")
            yield file
    except FileNotFoundError:
        raise CheckpointError(f"{path}: no such checkpoint") from None
    except (OSError, KeyError, ValueError, TypeError, RuntimeError) as error:
        raise CheckpointError(f"{path}: not a readable checkpoint ({error})") from error


def _read(file: h5py.File) -> Checkpoint:
    x_faces, y_faces = (file[name][:] for name, _ in FACES)
    periodic_x, periodic_y = (bool(side) for side in file.attrs["periodic"])
    mesh = Mesh(x_faces, y_faces, (periodic_x, periodic_y))
    conserved = np.array([file[name][:].T for name, _, _ in FIELDS])
    if conserved.shape[1:] != mesh.cells:
        raise ValueError(f"fields of shape {conserved.shape[1:]} on a mesh of {mesh.cells} cells")
    return Checkpoint(
        mesh, conserved, float(file.attrs["time"]), int(file.attrs["steps"]), int(file.attrs["rejected_steps"]),
        float(file.attrs["dt_limit"]),
        {name: (float(entry[0]), float(entry[1])) for name, entry in file["ledger"].attrs.items()},
        {name: values[:] for name, values in file["integrator"].items()},
        str(file.attrs["deck"]),
    )  # fmt: skip
