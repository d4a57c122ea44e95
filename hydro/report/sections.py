"""The parts of the page of a run, by its kind. What the folder does not hold is left out."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hydro.choices import KINDS
from hydro.compare.subject import AUTO
from hydro.driver.ledger import BALANCE
from hydro.errors import DeckError, HydroError
from hydro.observables import Observables, observables_of
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

# Keys of summaries that a page begins with, after the observables, as far as they are there.
FACTS = {
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
NORMS = ("L1", "L2", "max")


@dataclass(frozen=True)
class Content:
    """What a page is about: the folder of a run, its deck, and its summary, empty while there is none."""

    folder: RunFolder
    deck: Any
    summary: Row

    @property
    def observables(self) -> Observables:
        """The set of the deck's problem."""
        return observables_of(self.deck)

    @property
    def told(self) -> dict[str, str]:
        """What is told of a state, by the names of the observables: their labels."""
        names = ["time", *(name for name, _, _ in self.observables.closing)]
        return {name: self.observables.label(name) for name in names}

    def picture(self, name: str, alt: str, caption: str = "") -> list[Figure]:
        """A picture of the folder, if it is there."""
        return pictures(self.folder.pictures / name, alt, caption)


def sections_of(content: Content) -> Iterator[Section]:
    """All parts of the page, some of them empty."""
    scales, warnings = described(content)
    yield Section("In brief", [*facts(content), *warnings])
    yield from PARTS.get(content.deck.kind, other)(content)
    yield Section("Scales", scales)
    yield Section("Deck", [Code(content.folder.deck.read_text(encoding="utf-8"))])


def facts(content: Content) -> list[Block]:
    """The numbers that are looked for first, those of the last snapshot among them."""
    summary = content.summary
    known, names = {**summary, **(summary.get("snapshots") or [{}])[-1]}, content.told | FACTS
    found = [(names[key], shown(known[key])) for key in names if key in known]
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
    yield Section("Density", [*density_panels(content), *snapshot_table(content)])
    yield Section("Movie", movie(content.folder))
    yield Section("History", history(content))
    alt = "Density, temperature, pressure and velocity along x, averaged over y, at the output times"
    yield Section("Profiles", content.picture("profiles.png", alt, "Averages over y; later times are darker."))
    yield Section("Energy ledger", ledger(content))
    yield Section("Beside a steady state", comparison(content))


def density_panels(content: Content) -> list[Block]:
    """The maps of the snapshots, or of as many of them as fit."""
    files = sorted(content.folder.pictures.glob("density_*.png"))
    snapshots = content.summary.get("snapshots", [])
    rows = snapshots if len(snapshots) == len(files) else [{}] * len(files)
    which = np.unique(np.linspace(0, len(files) - 1, MOST_PANELS).astype(int)).tolist() if files else []
    figures = [picture(files[k], density_words(content.observables, rows[k])) for k in which]
    return [Gallery(figures)] if figures else []


def density_words(observables: Observables, snapshot: Row) -> str:
    """A map of the density in words."""
    words, span = "Map of the density n", observables.span
    if "time" in snapshot:
        words += f" at t = {number(snapshot['time'])}"
    if snapshot and span.curves:
        high, low = (number(snapshot[curve.column]) for curve in span.curves)
        words += f": {span.words} from {low} to {high}"
    return words


def snapshot_table(content: Content) -> list[Block]:
    """The numbers of the snapshots."""
    told = content.told
    rows = [[snapshot[key] for key in told] for snapshot in content.summary.get("snapshots", [])]
    return [Table("At the output times.", list(told.values()), rows)] if rows else []


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


def history(content: Content) -> list[Block]:
    """Curves of what the run has noted."""
    from hydro.pictures.history import history_panel  # matplotlib is slow to import

    try:
        rows = read_history(content.folder.path).reset_index()
    except DeckError:  # there is none yet
        return []
    if len(rows) < 2:
        return []
    span = f"from t = {number(rows['time'].min())} to {number(rows['time'].max())}"
    panels = content.observables.panels
    figures = [drawing(history_panel(rows, panel), f"{panel.words} against time, {span}") for panel in panels]
    return [Gallery(figures)]


def comparison(content: Content) -> list[Block]:
    """What `compare` has found, if it was run."""
    folder, compared = content.folder, content.observables.compared
    if not (folder.comparison / "compare.json").exists():
        return []
    found = json.loads((folder.comparison / "compare.json").read_text(encoding="utf-8"))
    last, steady = found["checkpoints"][-1], found["steady_state"]
    when = f"t = {number(last['time'])}"
    distance = f"Distance from the steady state with {found['wave']} half-waves against time, on a logarithmic axis"
    return [
        Lines([f"{origin(found['steady'])}: {found['wave']} half-waves, {found['alignment']}."]),
        Table("", ("", when, "steady"), [(each.label, last[each.name], steady[each.name]) for each in compared]),
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
    yield Section("Density", content.picture("density.png", density_words(content.observables, summary)))
    rows = [
        (entry["sector"], number(rate), number(frequency))
        for entry in summary.get("sectors", [])
        for rate, frequency in zip(entry["growth_rates"], entry["frequencies"], strict=True)
    ]
    caption = "Growth rates and frequencies of the leading modes, per unit of time, by symmetry."
    table = [Table(caption, ("symmetry", "growth rate", "frequency"), rows)] if rows else []
    alt = "Maps of the relative change of the density in the leading mode of each symmetry"
    words = [Lines([summary["damping"]])] if "damping" in summary else []
    yield Section(
        "Modes", [*words, *table, *content.picture("modes.png", alt, "Red where it gets denser, blue where thinner.")]
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
