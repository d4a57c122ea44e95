"""A number of the members of a sweep: against one key, or as a map over two."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydro.pictures.branches import LABELS
from hydro.pictures.style import publish

WORDS = {
    "wall_max": "largest $n/n_c$ on the wall $x=0$",
    "wall_min": "smallest $n/n_c$ on the wall $x=0$",
    "gas_density": "$n/n_c$ at the wall $x=1$",
    "half_waves": "number of half-waves across the box",
    "drift": r"$|d\,\log n/dt|$ on the wall $x=0$",
    "growth_rate": r"growth rate $\lambda L_x/T_*^{1/2}$",
}
COLUMNS = 3
MOST_PANELS = 12


def draw(path: Path, table: Any, name: str, chain: bool = False) -> None:
    """The variable `name` of a sweep's Dataset, into `path`.png and `path`.pdf.

    A map over the first two axes that have numbers, one for each combination of the others; where there is only one
    such axis, curves along it. Members of a chain are joined by arrows in the order in which they followed each other.
    Seeds beside other axes are averaged over, and curves then have standard errors.
    """
    values, errors = (table[name], None) if chain else ensemble(table[name])
    dims = list(values.dims)
    numeric = [dim for dim in dims if table[dim].dtype.kind == "f" and table.sizes[dim] > 1]
    if len(numeric) > 1 and not chain:
        maps(path, values, numeric[:2])
    else:
        along = dims[-1] if chain or not numeric else numeric[0]
        curves(path, values, errors, along, chain)


def ensemble(values: Any) -> tuple[Any, Any]:
    """The mean over seeds and its standard error; all values, and None, where there are no seeds or nothing else."""
    seeds = [dim for dim in values.dims if dim.endswith(".seed") and values.sizes[dim] > 1]
    if len(seeds) in (0, values.ndim):
        return values, None
    return values.mean(seeds), values.std(seeds, ddof=1) / np.sqrt(values.count(seeds))


def maps(path: Path, values: Any, plane: Sequence[str]) -> None:
    """Maps over two axes, all with the same shades."""
    panels = list(itertools.islice(slices(values, plane), MOST_PANELS))
    columns = min(COLUMNS, len(panels))
    rows = -(-len(panels) // columns)
    figure = Figure(figsize=(3.6 * columns + 0.8, 3.2 * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).ravel()
    low, high = np.nanmin(values), np.nanmax(values)
    for axis in axes[len(panels) :]:
        axis.set_axis_off()
    for axis, (title, part) in zip(axes, panels, strict=False):
        x, y = (part[dim].to_numpy() for dim in plane)
        shades = axis.pcolormesh(x, y, part.transpose(*plane).to_numpy().T, vmin=low, vmax=high, shading="nearest")
        axis.set_title(title, fontsize=9)
        axis.set_xlabel(label(plane[0]))
        axis.set_ylabel(label(plane[1]))
    figure.colorbar(shades, ax=list(axes), label=said(values.name))
    publish(figure, path)


def curves(path: Path, values: Any, errors: Any, along: str, chain: bool) -> None:
    """Curves along one axis, one for each combination of the others."""
    figure = Figure(figsize=(5.6, 4.0), layout="constrained")
    axis = figure.add_subplot()
    bars = itertools.repeat(None) if errors is None else (part.to_numpy() for _, part in slices(errors, (along,)))
    for (title, part), bar in zip(slices(values, (along,)), bars, strict=False):
        x, y = part[along].to_numpy(), part.to_numpy()
        (line,) = axis.plot(x, y, "o" if chain else "o-", markersize=4.0, linewidth=1.1, label=title or None)
        if bar is not None:
            axis.errorbar(x, y, bar, fmt="none", capsize=2.5, elinewidth=1.1, ecolor=line.get_color())
        if chain:
            arrows(axis, x, y, line.get_color())
    axis.set_xlabel(label(along))
    axis.set_ylabel(said(values.name) + (", mean over seeds" if errors is not None else ""))
    if values.ndim > 1:
        axis.legend(fontsize=8)
    publish(figure, path)


def arrows(axis: Axes, x: np.ndarray, y: np.ndarray, color: Any) -> None:
    """Arrows from point to point."""
    for before, after in itertools.pairwise(zip(x, y, strict=True)):
        if np.isfinite([*before, *after]).all():
            axis.annotate("", after, before, arrowprops={"arrowstyle": "->", "color": color, "linewidth": 0.9})


def slices(values: Any, kept: Sequence[str]) -> Iterator[tuple[str, Any]]:
    """Parts of an array along the axes `kept`, one for each combination of the others, with titles."""
    others = [dim for dim in values.dims if dim not in kept]
    for places in itertools.product(*(range(values.sizes[dim]) for dim in others)):
        part = values.isel(dict(zip(others, places, strict=True)))
        yield ", ".join(shown(dim, part[dim].item()) for dim in others), part


def label(key: str) -> str:
    """What stands beside an axis."""
    return LABELS.get(key.rpartition(".")[2], key)


def said(name: str) -> str:
    """A number of a run in words."""
    return WORDS.get(name, name.replace("_", " "))


def shown(key: str, value: Any) -> str:
    """A coordinate in a title."""
    return f"{label(key)} = {value:g}" if isinstance(value, float) else f"{value}"
