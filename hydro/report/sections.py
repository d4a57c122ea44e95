"""The parts of the page of a run, by its kind. What the folder does not hold is left out."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hydro.compare.subject import AUTO
from hydro.driver.ledger import BALANCE
from hydro.errors import DeckError, HydroError
from hydro.kinds.table import KINDS
from hydro.output.checkpoint import read_words
from hydro.output.dataset import read_history
from hydro.output.folder import RunFolder
from hydro.report.blocks import (
    NO_BREAK,
    Block,
    Code,
    Facts,
    Figure,
    Gallery,
    Lines,
    Section,
    Table,
    Video,
    data_uri,
    drawing,
    number,
    picture,
)

MOST_PANELS = 12
WARNING = "warning: "

Row = dict[str, Any]

# Keys of summaries that a page begins with, as far as they are there.
FACTS = {
    "time": "time",
    "wall_max": "largest n(0, y)",
    "wall_min": "smallest n(0, y)",
    "gas_density": "n at x = 1",
    "max_mach": "largest Mach number",
    "pressure": "pressure",
    "growth_rate": "growth rate",
    "stable": "stable",
    "points": "points",
    "bifurcations": "bifurcations",
    "folds": "folds",
    "rows": "critical aspect ratios",
    "cells": "cells",
    "integrator": "integrator",
    "steps": "steps",
    "rejected_steps": "rejected steps",
    "newton_iterations": "Newton iterations",
    "residual": "residual",
    "mass_drift": "mass drift",
    "wall_seconds": "seconds of computing",
}
NUMBERS = {"time": "t", "wall_max": "max n(0, y)", "wall_min": "min n(0, y)", "gas_density": "n at x = 1"}
NORMS = ("L1", "L2", "max")


@dataclass(frozen=True)
class Content:
    """What a page is about: the folder of a run, its deck, and its summary, empty while there is none."""

    folder: RunFolder
    deck: Any
    summary: Row

    def picture(self, name: str, alt: str, caption: str = "") -> list[Figure]:
        """A picture of the folder, if it is there."""
        return pictures(self.folder.pictures / name, alt, caption)


def sections_of(content: Content) -> Iterator[Section]:
    """All parts of the page, some of them empty."""
    scales, warnings = described(content)
    yield Section("In brief", [*facts(content.summary), *warnings])
    yield from PARTS.get(content.deck.kind, other)(content)
    yield Section("Scales", scales)
    yield Section("Deck", [Code(content.folder.deck.read_text(encoding="utf-8"))])


def facts(summary: Row) -> list[Block]:
    """The numbers that are looked for first, those of the last snapshot among them."""
    known = {**summary, **(summary.get("snapshots") or [{}])[-1]}
    found = [(name, shown(known[key])) for key, name in FACTS.items() if key in known]
    return [Facts(found)] if found else []


def shown(value: Any) -> Any:
    """Numbers of cells as a product, how many there are of other things."""
    if not isinstance(value, list):
        return value
    return " × ".join(map(str, value)) if all(isinstance(item, int) for item in value) else len(value)


def described(content: Content) -> tuple[list[Block], list[Block]]:
    """What `check` says of the deck: its scales, and its warnings."""
    try:
        lines = KINDS[content.deck.kind].describe(content.deck)
    except HydroError as error:
        return [Lines([f"not known: {error}"])], []
    warnings = [line.removeprefix(WARNING) for line in lines if line.startswith(WARNING)]
    rows = [re.split(r" {2,}", line.strip(), maxsplit=2) for line in lines if not line.startswith(WARNING)]
    scales: list[Block] = []
    if sentences := [" ".join(row) for row in rows if len(row) < 2]:
        scales.append(Lines(sentences))
    if named := [[*row, ""][:3] for row in rows if len(row) > 1]:
        scales.append(Table("", ("scale", "value", "meaning"), named, stacked=True))
    return scales, [Lines(warnings, warning=True)] if warnings else []


# Evolution


def evolution(content: Content) -> Iterator[Section]:
    """Densities, movie, history, ledger, comparison."""
    summary = content.summary
    yield Section("Density", [*density_panels(content), *snapshot_table(summary)])
    yield Section("Movie", movie(content.folder))
    yield Section("History", history(content.folder))
    alt = "Density, temperature, pressure and velocity along x, averaged over y, at the output times"
    yield Section("Profiles", content.picture("profiles.png", alt, "Averages over y; later times are darker."))
    yield Section("Energy ledger", ledger(content))
    yield Section("Beside a steady state", comparison(content.folder))


def density_panels(content: Content) -> list[Block]:
    """The maps of the snapshots, or of as many of them as fit."""
    files = sorted(content.folder.pictures.glob("density_*.png"))
    snapshots = content.summary.get("snapshots", [])
    rows = snapshots if len(snapshots) == len(files) else [{}] * len(files)
    which = np.unique(np.linspace(0, len(files) - 1, MOST_PANELS).astype(int)).tolist() if files else []
    figures = [picture(files[k], density_words(rows[k])) for k in which]
    return [Gallery(figures)] if figures else []


def density_words(snapshot: Row) -> str:
    """A map of the density in words."""
    if not snapshot:
        return "Map of the density n"
    low, high = number(snapshot["wall_min"]), number(snapshot["wall_max"])
    return f"Map of the density n at t = {number(snapshot['time'])}: on the wall x = 0 from {low} to {high}"


def snapshot_table(summary: Row) -> list[Block]:
    """The numbers of the snapshots."""
    rows = [[snapshot[key] for key in NUMBERS] for snapshot in summary.get("snapshots", [])]
    return [Table("On the walls, at the output times.", list(NUMBERS.values()), rows)] if rows else []


def ledger(content: Content) -> list[Block]:
    """The books of energy, in the words of the newest checkpoint."""
    entries = content.summary.get("energy_ledger", {})
    words = BALANCE | read_words(reversed(content.folder.saved()), "ledger")
    rows = [(words.get(name, (name, ""))[0], amount) for name, amount in entries.items()]
    return [Table("Integrals over the run, in n_c T_* L_x².", ("energy", "amount"), rows)] if rows else []


def movie(folder: RunFolder) -> list[Block]:
    """The movie of the run."""
    if folder.movie.exists():
        return [Video(data_uri("video/mp4", folder.movie.read_bytes()), "Density against time")]
    return []


def history(folder: RunFolder) -> list[Block]:
    """Curves of what the run has noted."""
    from hydro.pictures.history import PANELS, history_panel  # matplotlib is slow to import

    try:
        rows = read_history(folder.path).reset_index()
    except DeckError:  # there is none yet
        return []
    if len(rows) < 2:
        return []
    span = f"from t = {number(rows['time'].min())} to {number(rows['time'].max())}"
    figures = [drawing(history_panel(rows, panel), f"{panel.words} against time, {span}") for panel in PANELS]
    return [Gallery(figures)]


def comparison(folder: RunFolder) -> list[Block]:
    """What `compare` has found, if it was run."""
    if not (folder.comparison / "compare.json").exists():
        return []
    found = json.loads((folder.comparison / "compare.json").read_text(encoding="utf-8"))
    last, steady = found["checkpoints"][-1], found["steady_state"]
    keys = [key for key in NUMBERS if key != "time"]
    when = f"t = {number(last['time'])}"
    distance = f"Distance from the steady state with {found['wave']} half-waves against time, on a logarithmic axis"
    return [
        Lines([f"{origin(found['steady'])}: {found['wave']} half-waves, {found['alignment']}."]),
        Table("", ("", when, "steady"), [(NUMBERS[key], last[key], steady[key]) for key in keys]),
        Table(
            f"Relative differences at {when}.", ("", *NORMS),
            [(field, *(last[field][norm] for norm in NORMS)) for field in ("density", "temperature")],
        ),
        *pictures(folder.comparison / "distance.png", distance, "Wide bands: fitted exponentials."),
        Table(
            "Rates of approach (negative) or departure, and leading eigenvalues. Shear flow, which the density "
            f"follows, decays at {number(found['friction_rate'])}.",
            ("difference", "fitted rate", "eigenvalue", "stretch of t"),
            [rate_row(entry) for entry in found["rates"]],
        ),
        *pictures(
            folder.comparison / "states.png",
            "Maps of density and temperature: of the run at its last checkpoint, of the steady state, their difference",
        ),
    ]  # fmt: skip


def origin(steady: str) -> str:
    """Where a steady state comes from."""
    return "The nearest steady state" if steady == AUTO else f"The steady state of {steady}"


def rate_row(entry: Row) -> tuple[Any, ...]:
    """A fitted rate beside its eigenvalue."""
    fit = entry["fit"]
    if fit is None:
        return entry["sector"], None, entry["growth_rate"], entry["note"]
    window = f"{number(fit['start'])} to {number(fit['end'])} ({fit['points']} checkpoints)"
    rate = f"{number(fit['rate'])} ±{NO_BREAK}{number(fit['error'], digits=1)}"
    return entry["sector"], rate, entry["growth_rate"], window


# The other kinds


def steady(content: Content) -> Iterator[Section]:
    """The state and its modes."""
    summary = content.summary
    alt = density_words({"time": 0.0, **summary}) if summary else "Map of the density n"
    yield Section("Density", content.picture("density.png", alt.replace(" at t = 0", "")))
    rows = [
        (entry["sector"], number(rate), number(frequency))
        for entry in summary.get("sectors", [])
        for rate, frequency in zip(entry["growth_rates"], entry["frequencies"], strict=True)
    ]
    caption = "Growth rates and frequencies of the leading modes, per unit of time, by symmetry."
    table = [Table(caption, ("symmetry", "growth rate", "frequency"), rows)] if rows else []
    alt = "Maps of the relative change of the density in the leading mode of each symmetry"
    yield Section(
        "Modes", [*table, *content.picture("modes.png", alt, "Red where it gets denser, blue where thinner.")]
    )


def branch(content: Content) -> Iterator[Section]:
    """The bifurcation diagram, and what lies on it."""
    alt = "Largest and smallest density on the wall x = 0, and growth rates, against the parameter"
    caption = "Solid where stable, dashed where unstable; squares are bifurcations, circles folds."
    yield Section("Branches", [*closing(content), *content.picture("branches.png", alt, caption)])


def stability(content: Content) -> Iterator[Section]:
    """The marginal curves, tongues and rows."""
    alt = "Critical aspect ratio of the extended state against area fraction"
    yield Section("Marginal curves", [*closing(content), *content.picture("marginal.png", alt)])
    keys = ("L", "f", "wall", "m", "aspect_ratio", "error")
    rows = [[row[key] for key in keys] for row in content.summary.get("rows", [])]
    table = Table(
        "All critical aspect ratios", ("L", "f", "wall", "half-waves", "aspect ratio", "error"), rows, folded=True
    )
    yield Section("Numbers", [table] if rows else [])


def other(content: Content) -> Iterator[Section]:
    """A kind without a page of its own: its closing words and all its pictures."""
    files = sorted(content.folder.pictures.glob("*.png"))
    shown_files = [figure for file in files for figure in pictures(file, f"Picture {file.stem}", file.stem)]
    yield Section("Results", [*closing(content), *shown_files])


PARTS: dict[str, Callable[[Content], Iterator[Section]]] = {
    "evolution": evolution,
    "steady": steady,
    "branch": branch,
    "stability": stability,
    "grains": evolution,
}


def closing(content: Content) -> list[Block]:
    """What the run has said at its end."""
    return [Lines(KINDS[content.deck.kind].closing(content.summary))] if content.summary else []


def pictures(path: Path, alt: str, caption: str = "") -> list[Figure]:
    """The picture of a file, if it is there."""
    return [picture(path, alt, caption)] if path.exists() else []
