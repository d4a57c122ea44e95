"""Checkpoints: everything that is needed to look at a state, or to go on from it, in one HDF5 file.

The first 512 bytes of the file, which HDF5 leaves to its users, hold the SHA-256 of all bytes behind them. It is
verified before anything in the file is believed.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import math
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np

import hydro
from hydro.errors import CheckpointError
from hydro.mesh import Mesh
from hydro.output.files import write_bytes
from hydro.revision import git_revision
from hydro.state import State, refuse_inadmissible

FORMAT = "hydro checkpoint"
VERSION = 3
SEAL = 512  # bytes
TIME = "L_x/T_*^(1/2)"

# Name, long name and unit of the conserved fields, in the order of the state. In the file x varies fastest, as other
# programs expect it of a mesh: datasets have the shape (ny, nx).
FIELDS = (
    ("density", "number density", "n_c"),
    ("momentum_x", "momentum density along x", "n_c T_*^(1/2)"),
    ("momentum_y", "momentum density along y", "n_c T_*^(1/2)"),
    ("energy", "granular and flow energy density", "n_c T_*"),
)
GROUPS = {
    "ledger": "energy given and lost, and what there was at the start: each a sum and its compensation",
    "integrator": "what the integrator remembers beside the fields",
    "snapshots": "numbers that describe the states at the output times so far",
}
FACES = (("x_faces", "cell faces in x"), ("y_faces", "cell faces in y"))


Words = tuple[str, str]  # long name and unit


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """A saved moment of a run.

    conserved: (4, nx, ny). deck: resolved TOML text. set_by: numbers of steps by what set them. ledger: pairs (sum,
    compensation) by entry, and the initial energy and mass. memory: what the integrator remembers. snapshots: rows of
    the summary so far. replaceable: names of the checkpoints that newer ones may replace. words: long names and units
    of the entries of the groups `ledger`, `integrator` and `snapshots`.
    """

    mesh: Mesh
    conserved: np.ndarray
    time: float
    deck: str
    steps: int = 0
    rejected: int = 0
    dt: float = 0.0
    dt_limit: float = math.inf
    wall_seconds: float = 0.0
    set_by: dict[str, int] = field(default_factory=dict)
    ledger: dict[str, tuple[float, float]] = field(default_factory=dict)
    memory: dict[str, np.ndarray] = field(default_factory=dict)
    snapshots: list[dict[str, Any]] = field(default_factory=list)
    replaceable: list[str] = field(default_factory=list)
    words: dict[str, dict[str, Words]] = field(default_factory=dict)

    @classmethod
    def of(cls, state: State, deck: str) -> Checkpoint:
        """A state that no run has led to, to start from. RunFailed if it is not that of a gas."""
        refuse_inadmissible(state)
        return cls(state.mesh, state.conserved, state.time, deck)


def write_checkpoint(path: Path, saved: Checkpoint) -> None:
    """Write `saved` to `path`, whole or not at all."""
    image = io.BytesIO()
    with h5py.File(image, "w", userblock_size=SEAL) as file:
        _write(file, saved)
    write_bytes(path, sealed(image.getvalue()))


def sealed(image: bytes) -> bytes:
    """An HDF5 file with the checksum of what lies behind its first 512 bytes in them."""
    return _seal(image) + image[SEAL:]


def _seal(image: bytes) -> bytes:
    digest = hashlib.sha256(memoryview(image)[SEAL:]).hexdigest()
    return f"{FORMAT}, SHA-256 of all behind the first {SEAL} bytes:\n{digest}\n".encode().ljust(SEAL, b"\0")


def _write(file: h5py.File, saved: Checkpoint) -> None:
    file.attrs.update(
        format=FORMAT, format_version=VERSION, hydro_version=hydro.__version__, deck=saved.deck,
        time=saved.time, time_unit=TIME, steps=saved.steps, rejected_steps=saved.rejected,
        dt=saved.dt, dt_limit=saved.dt_limit, wall_seconds=saved.wall_seconds, periodic=saved.mesh.periodic,
    )  # fmt: skip
    if revision := git_revision():
        file.attrs["git_revision"] = revision
    for (name, long_name, unit), values in zip(FIELDS, saved.conserved, strict=True):
        _dataset(file, name, values.T, long_name, unit)
    for (name, long_name), faces in zip(FACES, (saved.mesh.x_faces, saved.mesh.y_faces), strict=True):
        _dataset(file, name, faces, long_name, "L_x")
    rows = saved.snapshots
    numbers = {name: [row[name] for row in rows] for name in (rows[0] if rows else ()) if name != "checkpoint"}
    for group, entries in (("ledger", saved.ledger), ("integrator", saved.memory), ("snapshots", numbers)):
        words = saved.words.get(group, {})
        parent = _group(file, group, GROUPS[group], ordered=True)
        for name, values in entries.items():
            _dataset(parent, name, values, *words.get(name, (name, "")))
    _group(file, "steps_by", "numbers of steps by what set them").attrs.update(saved.set_by)
    _names(file["snapshots"], "checkpoint", [row["checkpoint"] for row in rows], "their files")
    _names(file, "replaceable", saved.replaceable, "files of checkpoints that newer ones may replace")


def _group(file: h5py.File, name: str, long_name: str, ordered: bool = False) -> h5py.Group:
    """A group; `ordered`, if what it holds is to be read in the order of writing."""
    group = file.create_group(name, track_order=ordered)
    group.attrs["long_name"] = long_name
    return group


def _dataset(parent: h5py.Group, name: str, values: Any, long_name: str, unit: str) -> None:
    dataset = parent.create_dataset(name, data=np.asarray(values))
    dataset.attrs.update(long_name=long_name, units=unit)


def _names(parent: h5py.Group, name: str, values: list[str], long_name: str) -> None:
    dataset = parent.create_dataset(name, data=values, shape=(len(values),), dtype=h5py.string_dtype())
    dataset.attrs["long_name"] = long_name


def averaged(saved: Checkpoint) -> np.ndarray:
    """Fields of a checkpoint, (4, nx, ny): averages over the looks that it has; without any, those of the moment."""
    seen = saved.memory.get("look_fields", ())
    return np.mean(seen, axis=0) if len(seen) else saved.conserved


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

    CheckpointError as of `read_checkpoint`, but the checksum is not compared: that would take reading the whole file.
    """
    with _opened(path, verify=False) as file:
        return dict(file.attrs)


def read_words(paths: Iterable[Path], group: str) -> dict[str, Words]:
    """Long names and units of what a group holds, by the first checkpoint that can be opened; nothing without one."""
    for path in paths:
        with contextlib.suppress(CheckpointError), _opened(path, verify=False) as file:
            return _words(file[group])
    return {}


def checkpoint_times(folder: Path, known: Mapping[Path, float] | None = None) -> tuple[dict[Path, float], list[str]]:
    """Times of the checkpoints in a folder, in order, and what is wrong with those that cannot be read.

    known: times of checkpoints that need not be opened again.
    """
    times, troubles = {}, []
    for path in folder.glob("*.h5"):
        if path.name.startswith("."):
            continue
        try:
            times[path] = known[path] if known and path in known else _read_time(path)
        except CheckpointError as error:
            troubles.append(str(error))
    return dict(sorted(times.items(), key=lambda entry: (entry[1], entry[0]))), troubles


def readable_times(folder: Path) -> dict[Path, float]:
    """Times of the checkpoints in a folder that can be opened, in order; the others are named on stderr."""
    times, troubles = checkpoint_times(folder)
    for trouble in troubles:
        leave_out(trouble)
    return times


def leave_out(trouble: str) -> None:
    """Say on stderr what is left out."""
    print(f"hydro: {trouble}; left out", file=sys.stderr)


def _read_time(path: Path) -> float:
    with _opened(path, verify=False) as file:
        return float(file.attrs["time"])


@contextlib.contextmanager
def _opened(path: Path, verify: bool = True) -> Iterator[h5py.File]:
    """The file of a checkpoint of this version; CheckpointError if it is none, or if reading it fails.

    verify: whether its checksum is compared, for which all of it has to be read.
    """
    try:
        with h5py.File(_verified(path) if verify else path, "r") as file:
            if file.attrs.get("format") != FORMAT:
                raise ValueError(f"its format is not {FORMAT!r}")
            if file.attrs["format_version"] != VERSION:
                raise ValueError(f"format version {file.attrs['format_version']}, this program reads {VERSION}")
            yield file
    except FileNotFoundError:
        raise CheckpointError(f"{path}: no such checkpoint") from None
    except (OSError, KeyError, ValueError, TypeError, RuntimeError) as error:
        raise CheckpointError(f"{path}: not a readable checkpoint ({error})") from error


def read_or_skip(path: Path) -> Checkpoint | None:
    """The checkpoint; None, and the reason on stderr, if it cannot be read."""
    try:
        return read_checkpoint(path)
    except CheckpointError as error:
        print(f"hydro: skipped {error}", file=sys.stderr)
        return None


def _verified(path: Path) -> io.BytesIO:
    """The content of a file; ValueError if it is not as it was written."""
    content = path.read_bytes()
    if content[:SEAL] == _seal(content):
        return io.BytesIO(content)
    if content.startswith(b"\x89HDF"):
        raise ValueError("it has no checksum: another program, or an older version of this one, wrote it")
    raise ValueError("damaged: the checksum of its content is not the one written into it")


def _read(file: h5py.File) -> Checkpoint:
    attributes = file.attrs
    x_faces, y_faces = (file[name][:] for name, _ in FACES)
    periodic_x, periodic_y = (bool(side) for side in attributes["periodic"])
    mesh = Mesh(x_faces, y_faces, (periodic_x, periodic_y))
    conserved = np.array([file[name][:].T for name, _, _ in FIELDS])
    if conserved.shape[1:] != mesh.cells:
        raise ValueError(f"fields of shape {conserved.shape[1:]} on a mesh of {mesh.cells} cells")
    return Checkpoint(
        mesh, conserved, float(attributes["time"]), str(attributes["deck"]),
        steps=int(attributes["steps"]),
        rejected=int(attributes["rejected_steps"]),
        dt=float(attributes["dt"]),
        dt_limit=float(attributes["dt_limit"]),
        wall_seconds=float(attributes["wall_seconds"]),
        set_by={name: int(count) for name, count in file["steps_by"].attrs.items() if name != "long_name"},
        ledger={name: (float(pair[0]), float(pair[1])) for name, pair in file["ledger"].items()},
        memory={name: values[:] for name, values in file["integrator"].items()},
        snapshots=_rows(file["snapshots"]),
        replaceable=_texts(file["replaceable"]),
        words={group: _words(file[group]) for group in GROUPS},
    )  # fmt: skip


def _rows(group: h5py.Group) -> list[dict[str, Any]]:
    """The snapshots, as the summary has them."""
    columns = {name: _texts(data) if name == "checkpoint" else data[:].tolist() for name, data in group.items()}
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def _words(group: h5py.Group) -> dict[str, Words]:
    """Long names and units of what a group holds."""
    words = {name: data.attrs for name, data in group.items()}
    return {name: (str(its["long_name"]), str(its.get("units", ""))) for name, its in words.items()}


def _texts(dataset: h5py.Dataset) -> list[str]:
    return dataset.asstr()[:].tolist()
