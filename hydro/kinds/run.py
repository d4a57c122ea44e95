"""Running a deck in its folder, from the command line or from Python."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hydro.choices import KINDS
from hydro.deck import Deck, dumps, load, parse, validate
from hydro.deck.evolution import RunDeck
from hydro.errors import extra
from hydro.output.folder import RunFolder

if TYPE_CHECKING:
    import xarray as xr


def run(
    deck: Deck | Mapping[str, Any] | str | os.PathLike[str],
    overrides: Iterable[str] = (),
    output: str | os.PathLike[str] | None = None,
    overwrite: bool = False,
    quiet: bool = True,
) -> xr.Dataset | dict[str, Any]:
    """Run a deck in its folder, as `python -m hydro DECK` does, and return what came out.

    deck: the path of a TOML file; nested dictionaries as such a file has them; or a deck that was read. overrides: as
    on the command line, "section.key=value". output: the folder; output/<name of the file> without it, output/run for a
    deck that has no file. overwrite: whether a run that the folder holds is replaced. quiet: no progress is shown.

    Of an evolution or grains it returns the states at the times that were saved, as `hydro.open_run` does; its history
    is `hydro.read_history(folder)`. Of every other kind, which has no states in time, the summary, as summary.json has
    it. Either names the folder: `attrs["folder"]`, `["folder"]`. DeckError for a deck or a folder that will not do,
    RunFailed if the run fails, NotInstalled without Dask for a run in time.
    """
    whole, name = read(deck, overrides)
    folder = RunFolder(Path(output or Path("output") / name))
    if isinstance(whole, RunDeck):
        with extra("dask", "hydro.run of a run in time"):  # hours of work shall not end there
            import dask.array  # noqa: F401
    run_in(folder, whole, overwrite, quiet)
    if isinstance(whole, RunDeck):
        from hydro.output.dataset import open_run  # xarray is slow to import

        return open_run(folder.path).assign_attrs(folder=str(folder.path))
    return folder.read_summary() | {"folder": str(folder.path)}


def read(deck: Deck | Mapping[str, Any] | str | os.PathLike[str], overrides: Iterable[str]) -> tuple[Deck, str]:
    """The deck with its overrides, and what its folder is called."""
    if isinstance(deck, Deck):
        return parse(dumps(deck), overrides), "run"
    if isinstance(deck, Mapping):
        return parse(dumps(validate(deck)), overrides), "run"
    return load(Path(deck), overrides), Path(deck).stem


def run_in(folder: RunFolder, deck: Deck, overwrite: bool, quiet: bool, **where: Any) -> dict[str, Any]:
    """Run a deck in a folder that nobody else works in; returns the summary. DeckError for a folder that will not do.

    where: the `scheduler` of a sweep.
    """
    kind = KINDS[deck.kind]
    with folder.held():
        folder.check(overwrite, deck if kind.goes_on else None)
        return kind.solve(deck, folder, quiet, **where)
