"""What evolution finds in the plane of area fraction and aspect ratio: the deck `problems/map.toml`.

    python benchmarks/papers/map.py docs > docs/map.md

Draws map.png into the folder: the states found, over the marginal curves of `problems/fig2.toml` and the folds of
`problems/folds.toml`. Runs that are complete in the folder `--output` are not repeated.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from hydro import markdown, open_sweep
from hydro.cli import main as hydro
from hydro.pictures.style import save

PROBLEMS = Path(__file__).parents[2] / "problems"
SETTLED = 1e-6  # drift, per unit time, up to which a state counts as found
FAINT = 1e-5  # variation of n(0, y), relative, up to which it may grow: noise keeps extended states at some 1e-6
CHANGING = "still changing"
STATES = {
    "extended": ("0.55", "extended"),
    "half-wave": ("tab:blue", "half-wave"),
    "full wave": ("tab:orange", "full wave"),
    "more": ("tab:green", "more waves"),
    CHANGING: ("tab:red", "still changing: coarsening, growing or decaying"),
}
NAMES = ("extended", "half-wave", "full wave")
STARTS = (("noise", "o"), ("one half-wave", "^"), ("two half-waves", "s"))

PAGE = """# A map of the states found by evolution

Printed by `python benchmarks/papers/map.py docs > docs/map.md`: `problems/map.toml`, {count} evolutions by
`lagrange-remap` to t = {end:g}, L = {L:g}, K = {K:g}, tau = {tau:g}, {cells} cells per unit length in y and {nx} in x,
stretched by {stretch:g}: {seconds:.0f} s of work. Marginal curves are those of the stability solver, folds those of
`problems/folds.toml`.

![States found in the plane of area fraction and aspect ratio](map.png)

*Three starts at each point, from left to right: noise of 10%, one half-wave of 90%, two half-waves of 90% (and 0.1% of
one, for what is its own mirror image would stay so). The colour is what is found at t = {end:g}. A pale square: one
start has ended in the extended state, another in a localized one.*

The number of half-waves is that of the largest cosine in n(0, y); a state is extended where n(0, y) varies by less
than 2% of its mean. It is found if the densities on the wall x = 0 change by less than {settled:g} of themselves per
unit time between t = {before:g} and the end and, in an extended state, their variation does not grow; else it is still
changing. Friction, which steady states do not know, is
stronger than in Fig. 4: with tau = 200 the dense starts slosh until a moving core cools to T = 1e-7, where the implicit
integrator has to take very short steps."""

READING = """
**Selection.** Inside the tongue everything ends in one half-wave, whatever it starts from: two clusters are unstable to
one growing at the other's cost, and have coarsened. What is still changing lies next to the tongue's border, where all
that grows or decays is slow. Right of it noise decays and a strong half-wave stays, as the subcritical bifurcation
there wants it. About halfway to the fold this start is no longer in the basin of the localized state. The branch solver
still has that state there, and evolution reaches it by steps in f: see `problems/hysteresis.toml`."""


def run(output: Path, deck: str, *overrides: str) -> Path:
    """The folder of a deck's run, which is made or finished if it is not there."""
    folder = output / deck
    if not (folder / "summary.json").exists() or not json.loads((folder / "summary.json").read_text())["completed"]:
        words = [str(PROBLEMS / f"{deck}.toml"), *overrides, "--output", str(folder)]
        if hydro([*words, *(["--overwrite"] if deck == "fig2" else [])]) != 0:
            raise SystemExit(f"{deck} failed")
    return folder


def found(half_waves: float, drift: float, grows: bool) -> str:
    """What a run has ended in."""
    if not drift < SETTLED or (half_waves == 0 and grows):
        return CHANGING
    return NAMES[int(half_waves)] if half_waves < len(NAMES) else "more"


def grows(summary: dict[str, Any]) -> bool:
    """Whether n(0, y) varies, and more so in the last snapshot of a run than in the one before."""
    before, after = (row["wall_max"] / row["wall_min"] - 1.0 for row in summary["snapshots"][-2:])
    return after > max(before, FAINT)


def states(table: Any, members: list[dict[str, Any]]) -> np.ndarray:
    """Names of what was found, shape (f, aspect ratio, start)."""
    growing = np.array([grows(summary) for summary in members])[table.member.values - 1]
    return np.vectorize(found)(table.half_waves.values, table.drift.values, growing)


def bistable(there: np.ndarray) -> np.ndarray:
    """Where starts have ended in the extended state and in localized ones, shape (f, aspect ratio)."""
    localized = np.isin(there, ("half-wave", "full wave", "more")).any(axis=-1)
    return localized & (there == "extended").any(axis=-1)


def draw(path: Path, table: Any, there: np.ndarray, rows: list[dict[str, Any]], folds: Any) -> None:
    """The map."""
    figure = Figure(figsize=(8.2, 6.4), layout="constrained")
    axis = figure.add_subplot()
    f, ratios = table["gas.f"].values, table["box.aspect_ratio"].values
    width, height = f[1] - f[0], ratios[1] - ratios[0]
    for i, j in np.argwhere(bistable(there)):
        corner = (f[i] - 0.46 * width, ratios[j] - 0.4 * height)
        axis.add_patch(Rectangle(corner, 0.92 * width, 0.8 * height, color="#f6eec0", zorder=0))
    for (i, j, k), name in np.ndenumerate(there):
        _, marker = STARTS[k]
        place = f[i] + (k - 1) * 0.27 * width
        axis.plot(place, ratios[j], marker, color=STATES[name][0], markersize=5.5, markeredgewidth=0.0)
    curves(axis, rows, folds)
    axis.set_xlim(f[0] - 0.7 * width, f[-1] + 0.7 * width)
    axis.set_ylim(ratios[0] - 0.7 * height, ratios[-1] + 0.7 * height)
    axis.set_xlabel("area fraction $f$")
    axis.set_ylabel(r"aspect ratio $\Delta$")
    figure.legend(handles=legend(there), loc="outside lower center", ncols=3, fontsize=8.5)
    save(figure, path)


def curves(axis: Axes, rows: list[dict[str, Any]], folds: Any) -> None:
    """Marginal curves and folds of one and two half-waves."""
    for m, line in ((1, "-"), (2, "--")):
        points = [(row["f"], row["aspect_ratio"]) for row in rows if row["m"] == m and row["aspect_ratio"] is not None]
        axis.plot(*zip(*points, strict=True), line, color="black", linewidth=1.2)
        axis.plot(folds.last_fold, m * folds["box.aspect_ratio"], line, color="tab:purple", linewidth=1.4)


def legend(there: np.ndarray) -> list[Any]:
    """What colours, symbols and lines mean."""
    used = [state for name, state in STATES.items() if name in there]
    return [
        *(Line2D([], [], color=colour, marker="o", linestyle="", label=label) for colour, label in used),
        Patch(color="#f6eec0", label="extended and localized, by the start"),
        *(Line2D([], [], color="0.3", marker=marker, linestyle="", label=f"from {name}") for name, marker in STARTS),
        Line2D([], [], color="black", label="marginal, one half-wave"),
        Line2D([], [], color="black", linestyle="--", label="marginal, two half-waves"),
        Line2D([], [], color="tab:purple", label="fold, one half-wave"),
        Line2D([], [], color="tab:purple", linestyle="--", label="fold, two half-waves"),
    ]


def counts(there: np.ndarray) -> str:
    """How often what was found, by start."""
    found = [[name, *(int(np.sum(there[..., k] == state)) for state in STATES)] for k, (name, _) in enumerate(STARTS)]
    return markdown.table(["start", *STATES], found)


def comparison(table: Any, there: np.ndarray, rows: list[dict[str, Any]], folds: Any) -> list[str]:
    """The map against the solvers, in sentences with the exceptions."""
    f, ratios = table["gas.f"].values, table["box.aspect_ratio"].values
    critical = {round(row["f"], 9): row["aspect_ratio"] or np.inf for row in rows if row["m"] == 1}
    inside = np.array([[ratio > critical[round(x, 9)] for ratio in ratios] for x in f])
    from_noise, decides = there[..., 0], bistable(there)
    fold = np.interp(ratios, folds["box.aspect_ratio"], folds.last_fold, left=np.nan)
    both = np.array([[not inside[i, j] and x < fold[j] for j in range(ratios.size)] for i, x in enumerate(f)])
    beyond = ~inside & ~both
    right = f[:, None] > 0.02  # the left bifurcation is supercritical: nothing localized is outside the tongue there
    return [
        *said("inside the tongue", inside, "noise has not stayed extended", from_noise != "extended", f, ratios),
        *said("outside the tongue", ~inside, "noise has ended extended", from_noise == "extended", f, ratios),
        *said("between tongue and fold", both & right, "the start decides", decides, f, ratios),
        *said("beyond the fold, or where there is none", beyond & right, "no start decides", ~decides, f, ratios),
    ]


def said(where: str, region: np.ndarray, what: str, holds: np.ndarray, f: np.ndarray, ratios: np.ndarray) -> list[str]:
    """One sentence: at how many points of a region something holds, and where it does not."""
    exceptions = [f"({f[i]:g}, {ratios[j]:g})" for i, j in np.argwhere(region & ~holds)]
    line = f"- {where.capitalize()}: at {int(np.sum(region & holds))} of {int(np.sum(region))} points {what}"
    return [line + (f"; not at (f, Delta) = {', '.join(exceptions)}." if exceptions else ".")]


def main() -> None:
    """Run what is missing, draw, print the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="for map.png")
    parser.add_argument("--output", type=Path, default=Path("output/map"))
    options = parser.parse_args()
    area_fractions = "stability.f={ start = 0.005, stop = 0.065, count = 121 }"
    marginal = run(options.output, "fig2", area_fractions, "stability.walls=['vibrating']", "stability.points=[]")
    folds = open_sweep(run(options.output, "folds"))
    folder = run(options.output, "map")
    table, rows = open_sweep(folder), json.loads((marginal / "summary.json").read_text())["rows"]
    members = [entry["summary"] for entry in json.loads((folder / "summary.json").read_text())["members"]]
    there = states(table, members)
    draw(options.folder / "map.png", table, there, rows, folds)
    from hydro.deck import load

    sweep: Any = load(folder / "deck.toml")
    base = sweep.base
    times = [row["time"] for row in members[0]["snapshots"]]
    print(PAGE.format(
        count=len(members), end=times[-1], before=times[-2],
        L=base.gas.L, K=base.gas.K, tau=base.gas.tau,
        cells=base.mesh.cells[1], nx=base.mesh.cells[0], stretch=base.mesh.stretch, settled=SETTLED,
        seconds=sum(member["wall_seconds"] for member in members),
    ))  # fmt: skip
    print("\n## What is found\n")
    print(counts(there))
    print("\n## Against the stability and branch solvers\n")
    print("\n".join(comparison(table, there, rows, folds)))
    print(READING)


if __name__ == "__main__":
    main()
