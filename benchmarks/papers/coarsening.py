"""Clusters that grow from noise in a long box and merge: the deck `problems/coarsening.toml`.

    python benchmarks/papers/coarsening.py docs > docs/coarsening.md

Draws coarsening.png into the folder: density along the wall x = 0 against time and y, and the number of clusters.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
from evolve import evolve
from matplotlib.figure import Figure

from hydro.deck import load
from hydro.driver.march import Run
from hydro.markdown import table
from hydro.mesh import Mesh
from hydro.observables.clustering import CLUSTER, clusters, wall_extremes, wall_profile
from hydro.pictures.style import save

DECK = Path(__file__).parents[2] / "problems" / "coarsening.toml"
EVERY = 2.5  # time between two looks
SAID_EVERY = 50.0  # time between two lines of progress

PAGE = """# Coarsening of clusters

Printed by `python benchmarks/papers/coarsening.py docs > docs/coarsening.md`: `problems/coarsening.toml`, a box of
aspect ratio {ratio:g} (L = {L:g}, f = {f:g}), from uniform density with noise of {amplitude:g} in every cell, on {nx} x
{ny} cells to t = {end:g} by `lagrange-remap`: {steps} steps in {seconds:.0f} s.

![Density along the wall against time, and number of clusters](coarsening.png)

*Above: n on the wall x = 0 against time and y; below: number of clusters.*

A cluster is a stretch of the wall x = 0 on which n(0, y) is above its mean over y, if n exceeds {above:g} times that
mean somewhere in it: one local maximum is counted, the largest, between two places where n falls below the mean. A
stretch that ends at a wall y = 0 or y = {ratio:g} is half of a cluster and its mirror image; it counts as one.

The table has the times at which the number of clusters changes, and the last one.
"""
HEADER = ("time", "clusters", "n(0, y): largest", "smallest", "mean")


class Wall:
    """n on the wall x = 0 at the times that were watched."""

    def __init__(self) -> None:
        self.times: list[float] = []
        self.lines: list[np.ndarray] = []
        self.extremes: list[tuple[float, float]] = []

    def watch(self, run: Run) -> None:
        state = run.state
        self.times.append(state.time)
        self.lines.append(wall_profile(state.density, state.mesh))
        self.extremes.append(wall_extremes(state.density, state.mesh))
        if state.time % SAID_EVERY == 0.0:
            line = f"t = {state.time:g}: {run.steps} steps, dt = {run.dt:.2g}, largest n = {state.density.max():.6f}"
            print(line, file=sys.stderr, flush=True)


def draw(path: Path, times: np.ndarray, lines: np.ndarray, counts: np.ndarray, mesh: Mesh) -> None:
    """Space-time map of the density above the number of clusters."""
    figure = Figure(figsize=(7.2, 5.4), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[3.0, 1.2])
    edges = np.concatenate([[0.0], 0.5 * (times[1:] + times[:-1]), times[-1:]])
    shades = above.pcolormesh(edges, mesh.y_faces, lines.T, cmap="gray_r", vmin=0.0, vmax=1.0, rasterized=True)
    above.set_xlim(0.0, times[-1])
    above.set_ylabel("$y/L_x$")
    figure.colorbar(shades, ax=above, pad=0.02).set_label("$n(0, y)/n_c$")
    below.step(times, counts, where="post", color="black", linewidth=1.0)
    below.set_ylim(0, counts.max() + 1)
    below.yaxis.get_major_locator().set_params(integer=True)
    below.set_ylabel("clusters")
    below.set_xlabel("$t\\,T_*^{1/2}/L_x$")
    save(figure, path)


def main(folder: Path, overrides: list[str]) -> None:
    """Run, draw, print the page."""
    wall = Wall()
    run = evolve(DECK, overrides, wall.watch, every=EVERY)
    deck: Any = load(DECK, overrides)
    mesh = run.state.mesh
    times, lines = np.array(wall.times), np.array(wall.lines)
    counts = np.array([clusters(line).size for line in lines])
    draw(folder / "coarsening.png", times, lines, counts, mesh)
    about = {"ratio": mesh.aspect_ratio, "L": deck.gas.L, "f": deck.gas.f, "amplitude": deck.initial.amplitude}
    nx, ny = mesh.cells
    print(PAGE.format(**about, nx=nx, ny=ny, end=run.end, steps=run.steps, seconds=run.wall_seconds, above=CLUSTER))
    changed = [*(np.flatnonzero(np.diff(counts)) + 1), times.size - 1]
    rows = []
    for k in changed:
        low, high = wall.extremes[k]
        rows.append((f"{times[k]:g}", counts[k], f"{high:.3f}", f"{low:.4f}", f"{lines[k].mean():.4f}"))
    print(table(HEADER, rows))
    places = [round(float(mesh.y[k]), 2) for k in clusters(lines[-1])]
    print(f"\nAt the end the clusters are at y = {', '.join(f'{place:g}' for place in places)}.")


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
