"""Runs as other programs' data: an xarray Dataset of the states, a pandas DataFrame of the history."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from hydro.errors import CheckpointError, DeckError, extra
from hydro.mesh import Mesh
from hydro.output.checkpoint import FIELDS, checkpoint_times, read_field, read_labels
from hydro.output.folder import RunFolder
from hydro.output.history import read_rows
from hydro.setup import gas_of, grain_diameter, mesh_of
from hydro.state import State

if TYPE_CHECKING:
    import dask.array as da

# Name, long name, unit, and what they are of a state and the grain diameter; beside the fields of a checkpoint.
DERIVED: tuple[tuple[str, str, str, Callable[[State, float], Any]], ...] = (
    ("velocity_x", "velocity along x", "T_*^(1/2)", lambda state, _: state.velocity[0]),
    ("velocity_y", "velocity along y", "T_*^(1/2)", lambda state, _: state.velocity[1]),
    ("temperature", "granular temperature", "T_*", lambda state, _: state.temperature),
    ("pressure", "pressure", "n_c T_*", lambda state, _: state.pressure),
    ("sound_speed", "adiabatic sound speed", "T_*^(1/2)", lambda state, _: state.sound_speed),
    ("mach_number", "speed over sound speed", "1", lambda state, _: state.mach),
    ("mean_free_path", "mean free path", "L_x", lambda state, d: d * state.gas.mean_free_path(state.density)),
)


class Axis(NamedTuple):
    """What the states of a run follow each other in: its name, their files, the coordinates along it."""

    name: str
    files: Sequence[Path]
    coordinates: dict[str, tuple[Any, ...]]


def open_run(path: str | os.PathLike[str]) -> xr.Dataset:
    """The states of the run in the folder `path`, as an xarray Dataset that reads a field when it is needed.

    Dimensions are x, y and, before them, `time` of an evolution or grains, `state` of a steady run, `point` of a
    branch. Fields are cell averages, the cells' widths are the coordinates dx and dy. Units are scaled; attributes of a
    variable hold its unit and long name. Beside the conserved fields of the checkpoints: velocity, temperature,
    pressure, sound speed, Mach number, mean free path, and the local Knudsen number l |grad n|/n, that is the mean free
    path over the length on which the density changes. The attributes of the Dataset hold the deck as TOML and the
    version of the program. Checkpoints that cannot be read are left out, with a warning.

    DeckError where the folder holds no run, or one without states of one mesh; CheckpointError where it has none yet,
    and, later, where a field cannot be read; NotInstalled without Dask.
    """
    with extra("dask", "open_run"):
        import dask.array as da

    folder = RunFolder(Path(path))
    deck: Any = folder.load_deck()
    if deck.kind not in AXES:
        raise DeckError(f"{path} holds a run of kind {deck.kind!r}, which keeps no states", "run folder")
    axis = AXES[deck.kind](folder, deck)
    if not axis.files:
        raise CheckpointError(f"{path} has no checkpoints yet")
    mesh = mesh_of(deck)
    fields = [_lazily(axis.files, name, mesh) for name, _, _ in FIELDS]
    state = State(gas_of(deck), mesh, da.stack(fields))
    variables = {name: (fields[k], long, unit) for k, (name, long, unit) in enumerate(FIELDS)}
    variables |= {name: (of(state, grain_diameter(deck)), long, unit) for name, long, unit, of in DERIVED}
    dimensions = (axis.name, "x", "y")
    data = xr.Dataset(
        {name: (dimensions, field, _words(long, unit)) for name, (field, long, unit) in variables.items()},
        {
            **axis.coordinates,
            "x": ("x", mesh.x, _words("cell centres in x", "L_x")),
            "y": ("y", mesh.y, _words("cell centres in y", "L_x")),
            "dx": ("x", mesh.dx, _words("cell widths in x", "L_x")),
            "dy": ("y", mesh.dy, _words("cell widths in y", "L_x")),
        },
        {
            "title": deck.about.title,
            "kind": deck.kind,
            "hydro_version": str(read_labels(axis.files[0])["hydro_version"]),
            "deck": folder.deck.read_text(encoding="utf-8"),
        },
    )
    return data.assign(knudsen_number=knudsen_number(data))


def knudsen_number(data: xr.Dataset) -> xr.DataArray:
    """l |grad n|/n, the mean free path over the length on which the density changes; central differences."""
    slope = np.hypot(data.density.differentiate("x"), data.density.differentiate("y"))
    number = data.mean_free_path * slope / data.density
    return number.assign_attrs(_words("local Knudsen number, l |grad n|/n", "1"))


def read_history(path: str | os.PathLike[str]) -> pd.DataFrame:
    """The history of the evolution in the folder `path`, one row for each moment, its index the time.

    Also while the run goes on. DeckError where there is none.
    """
    folder = RunFolder(Path(path))
    if not folder.history.exists():
        folder.load_deck()
        raise DeckError(f"{path} has no {folder.history.name}", "run folder")
    rows = read_rows(folder.history)
    if rows.empty:
        raise DeckError(f"{path} has no rows in {folder.history.name} yet", "run folder")
    return rows.set_index("time")


def _words(long_name: str, unit: str) -> dict[str, str]:
    return {"long_name": long_name, "units": unit}


def _lazily(files: Sequence[Path], name: str, mesh: Mesh) -> da.Array:
    """The field `name` of each file, shape (files, nx, ny), one block for each."""
    import dask.array as da

    nx, ny = mesh.cells

    def read(block_id: tuple[int, int, int]) -> np.ndarray:
        field = read_field(files[block_id[0]], name)
        if field.shape != mesh.cells:
            raise CheckpointError(f"{files[block_id[0]]}: {name} has the shape {field.shape}, not {mesh.cells}")
        return field[None]

    chunks = ((1,) * len(files), (nx,), (ny,))
    return da.map_blocks(read, chunks=chunks, dtype=float, meta=np.empty((0, 0, 0)))


def _times(folder: RunFolder, deck: Any) -> Axis:
    times, troubles = checkpoint_times(folder.checkpoints)
    for trouble in troubles:
        warnings.warn(f"{trouble}; left out", stacklevel=3)
    return Axis("time", list(times), {"time": ("time", list(times.values()), _words("time", "L_x/T_*^(1/2)"))})


def _states(folder: RunFolder, deck: Any) -> Axis:
    files = sorted(folder.checkpoints.glob("steady*.h5"))
    words = {"long_name": "the steady state, and it plus the leading mode of a symmetry"}
    return Axis("state", files, {"state": ("state", [file.stem for file in files], words)})


def _points(folder: RunFolder, deck: Any) -> Axis:
    if deck.branch.parameter == "aspect_ratio":
        raise DeckError(
            f"{folder.path} holds a branch in aspect_ratio: its points have no mesh in common", "run folder"
        )
    rows = pd.read_csv(folder.points) if folder.points.exists() else pd.DataFrame()
    files = [folder.checkpoints / f"{number + 1:04d}.h5" for number in range(len(rows))]
    return Axis("point", files, {name: ("point", rows[name].to_numpy()) for name in rows})


# What the states of a run follow each other in, by its kind.
AXES: dict[str, Callable[[RunFolder, Any], Axis]] = {
    "evolution": _times,
    "grains": _times,
    "steady": _states,
    "branch": _points,
}
