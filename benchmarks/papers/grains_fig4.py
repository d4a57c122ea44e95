"""Fig. 4 by grains, at full length, beside hydrodynamics: prints docs/grains_fig4.md, draws its pictures.

    python benchmarks/papers/grains_fig4.py docs > docs/grains_fig4.md

Runs that are complete in the folder `--output` are not repeated, those that were stopped go on. That with the grains of
the paper takes hours, each other one half an hour or so.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from physics.enskog import Enskog
from physics.extended import MU_CONDUCTION, MU_COOLING

from hydro.cli import main as hydro
from hydro.deck import load
from hydro.driver.march import Run, march
from hydro.driver.trackers import AtTimes
from hydro.errors import RunFailed
from hydro.gas import Grossman
from hydro.grains.integrator import dynamics_again
from hydro.initial import initial_state
from hydro.kinds.grains import measured
from hydro.markdown import table
from hydro.mesh import Mesh
from hydro.movies.frames import frame_time, frames, read_frame
from hydro.observables import CLUSTERING, observables_of
from hydro.observables.clustering import gas_density, wall_extremes
from hydro.output.checkpoint import averaged, read_checkpoint
from hydro.pictures.density import Map, density_panels
from hydro.pictures.grains import by_cluster, disks_at
from hydro.pictures.style import publish, save
from hydro.setup import gas_of, integrator_of, mesh_of
from hydro.state import State
from hydro.steady.localized import steady_state
from hydro.walls import VibratingWall

PROBLEMS = Path(__file__).parents[2] / "problems"
CELLS = (64, 128)  # of the flows
SAMPLES = 400  # of a flow, over its time
DENSE, WON = 0.7, 0.2  # a largest wall density, and a mean cosine of one half-wave: of 0.4 to 0.5 in the end
CLOSE = 0.25  # to the elastic wall: what a picture of clusters shows
SHOWN = (0.15, 0.35)  # of the mean x
WAVES = (1, 2)  # half-waves whose amplitudes are drawn
REDS = ("tab:red", "tab:orange", "tab:brown")  # seeds
COLOURS = {"closures": ("tab:blue", "--"), "Enskog": ("black", "-")}


class Box(NamedTuple):
    """Runs of grains: their deck, what is changed in it, and one or more seeds."""

    deck: str
    overrides: tuple[str, ...]
    seeds: tuple[int, ...]


BOXES = {
    "mu = 1": Box("grains_fig4", (), (0, 1, 2)),
    "large": Box(
        "grains_matched",
        ("gas.K=5e-3", "time.end=516", "output.times=[40, 200, 400, 516]", "grains.window=8"),
        (0,),
    ),
    "matched": Box("grains_matched", ("output.times=[100, 500, 1000, 1290]",), (0,)),
}


def matched(deck: Any) -> Grossman:
    """The paper's closures with the conduction and the densities that dilute grains have."""
    d = deck.gas.K / deck.gas.mu
    return Grossman(L=deck.gas.L * MU_COOLING / MU_CONDUCTION, K=MU_CONDUCTION * d)


GASES: dict[str, Callable[[Any], Any]] = {
    "closures": matched,
    "Enskog": lambda deck: Enskog(deck.gas.L, deck.gas.K / deck.gas.mu),
}


def amplitudes(density: np.ndarray, mesh: Mesh) -> list[float]:
    """Mean over the grains of cos(m pi y/aspect_ratio), for m in WAVES."""
    line = mesh.dx @ density * mesh.dy
    return [float(line @ np.cos(m * math.pi * mesh.y / mesh.aspect_ratio) / line.sum()) for m in WAVES]


def centre(density: np.ndarray, mesh: Mesh) -> float:
    """Mean x of the grains."""
    line = density @ mesh.dy * mesh.dx
    return float(line @ mesh.x / line.sum())


def grains(output: Path, name: str, seed: int) -> dict[str, Any]:
    """Series of a run of grains, and its summary; runs it if it is not there, and goes on with it if it was stopped.

    The series are those of the averages over windows that the frames of its movie hold; `shots` those at the times of
    the deck, with errors.
    """
    box = BOXES[name]
    folder = output / f"{name.replace(' ', '')}_{seed}"
    summary = folder / "summary.json"
    if not (summary.exists() and json.loads(summary.read_text())["completed"]):
        begun = (folder / "deck.toml").exists()
        begin = [str(PROBLEMS / f"{box.deck}.toml"), f"grains.seed={seed}", "output.movie=true"]
        words = ["restart", str(folder)] if begun else [*begin, "--output", str(folder)]
        if hydro([*words, *box.overrides]):
            raise SystemExit(f"{name} failed")
    deck: Any = load(folder / "deck.toml")
    mesh, pictures, made = mesh_of(deck), frames(folder / "frames"), json.loads(summary.read_text())
    fields = [read_frame(path) for path in pictures]
    low, high = np.array([wall_extremes(density, mesh) for density in fields]).T
    shown: Any = load(PROBLEMS / f"{box.deck}.toml", box.overrides)
    kept = [shot["checkpoint"] for shot in made["snapshots"] if shot["time"] in shown.output_times]
    saved = [read_checkpoint(folder / "checkpoints" / name) for name in kept]
    estimated, like = observables_of(deck).estimated, State(gas_of(deck), mesh, saved[-1].conserved)
    return {
        "time": np.array([frame_time(path) for path in pictures]), "wall_max": high, "wall_min": low,
        "gas_density": np.array([density[-1] @ mesh.dy / mesh.aspect_ratio for density in fields]),
        "centre": np.array([centre(density, mesh) for density in fields]),
        "amplitudes": np.array([amplitudes(density, mesh) for density in fields]),
        "shots": [{"time": each.time, **measured(estimated, each.memory["look_fields"], like)} for each in saved],
        "saved": saved, "deck": deck, "summary": made,
    }  # fmt: skip


def setting(name: str, gas_of: Callable[[Any], Any]) -> tuple[Any, Any, VibratingWall]:
    """The deck of a box of grains, a gas in their place, and the wall that gives it the same heat."""
    deck: Any = load(PROBLEMS / f"{BOXES[name].deck}.toml", BOXES[name].overrides)
    gas = gas_of(deck)
    return deck, gas, VibratingWall(strength=deck.gas.K * deck.wall.W)


def flow(name: str, gas_of: Callable[[Any], Any], number: int) -> dict[str, Any]:
    """Series of the hydrodynamics of a gas, viscous, before the wall that gives the same heat.

    From the same start, and an amplitude of one half-wave as large as the noise of that many grains.
    """
    deck, gas, wall = setting(name, gas_of)
    words = [f"mesh.cells=[{CELLS[0]},{CELLS[1]}]", "gas.viscosity=1", "gas.tau=inf", "output.times=[]"]
    odd = math.sqrt(2.0 / number)  # what the positions of so many grains leave of one half-wave, by chance
    start = f"{{kind='modes', waves=[1, 2], amplitudes=[{odd:g}, {deck.initial.amplitude:g}]}}"
    words += [f"initial={start}", f"wall.W={wall.strength / gas.K:.17g}", f"gas.K={gas.K:.17g}"]
    flowing: Any = load(PROBLEMS / "fig4.toml", [*words, f"gas.L={gas.L:.17g}", f"time.end={deck.time.end:g}"])
    begin = initial_state(flowing)
    state = State(gas, begin.mesh, begin.conserved)
    series: dict[str, Any] = {key: [] for key in ("time", "wall_min", "wall_max", "centre", "amplitudes")}

    def watch(run: Run) -> None:
        n, mesh = run.state.density, run.state.mesh
        values = (run.state.time, *wall_extremes(n, mesh), centre(n, mesh), amplitudes(n, mesh))
        for key, value in zip(series, values, strict=True):
            series[key].append(value)

    try:
        march(state, integrator_of(flowing, state), deck.time.end, [AtTimes(watch, (), deck.time.end / SAMPLES)])
    except RunFailed as failure:
        print(f"{name}, {type(gas).__name__}: {failure}", file=sys.stderr)
    return {key: np.array(values) for key, values in series.items()}


def late(runs: list[dict[str, Any]]) -> list[str]:
    """Means over the second half of runs of grains: wall densities, density at x = 1, mean x, sizes of amplitudes."""
    values = []
    for found in runs:
        second = found["time"] > 0.5 * found["time"][-1]
        means = [found[key][second].mean() for key in ("wall_max", "wall_min", "gas_density", "centre")]
        values.append([*means, *np.abs(found["amplitudes"][second]).mean(axis=0)])
    return [over_seeds(column) for column in zip(*values, strict=True)]


def over_seeds(values: Sequence[float], error: float = math.nan) -> str:
    """Mean of runs, with its standard error if there are several; of a single one, with an `error` that is known."""
    if len(values) > 1:
        error = float(np.std(values, ddof=1)) / math.sqrt(len(values))
    mean = f"{np.mean(values):.3g}"
    return f"{mean} ± {error:.1g}" if error > 0.0 else mean


def at_rest(name: str, gas_of: Callable[[Any], Any]) -> list[str]:
    """The same of the steady state of one half-wave of a gas."""
    deck, gas, wall = setting(name, gas_of)
    try:
        with np.errstate(all="ignore"):
            state = steady_state(gas, wall, Mesh.rectangle(CELLS, deck.box.aspect_ratio), deck.gas.f, 1).state
    except RunFailed:
        return ["none"] * 6
    low, high = wall_extremes(state.density, state.mesh)
    sizes = np.abs(amplitudes(state.density, state.mesh))
    numbers = (high, low, gas_density(state, wall), centre(state.density, state.mesh), *sizes)
    return [f"{value:.3g}" for value in numbers]


def upright(sizes: np.ndarray) -> np.ndarray:
    """Amplitudes as they are, or their mirror images: that of one half-wave ends positive."""
    return sizes * np.where(sizes[-1] < 0.0, [-1.0, 1.0], 1.0)


def draw(results: dict[str, Any]) -> Figure:
    """Wall densities, and the amplitudes of one and two half-waves, against time."""
    figure = Figure(figsize=(4.3 * len(results), 8.2), layout="constrained")
    axes = figure.subplots(4, len(results), sharex="col", sharey="row")
    for column, (name, (runs, flows)) in enumerate(results.items()):
        walls, centres, *waves = axes[:, column]
        walls.set_title(f"{runs[0]['summary']['grains']} grains, {name}", fontsize=10)
        for key in ("wall_max", "wall_min"):
            for number, found in enumerate(runs):
                label = "grains" if key == "wall_max" and number == 0 else None
                walls.plot(found["time"], found[key], color=REDS[number], linewidth=0.8, label=label)
            for gas, series in flows.items():
                (colour, dash), label = COLOURS[gas], gas if key == "wall_max" else None
                walls.plot(series["time"], series[key], dash, color=colour, linewidth=1.1, label=label)
        for number, found in enumerate(runs):
            centres.plot(found["time"], found["centre"], color=REDS[number], linewidth=0.8)
        for gas, series in flows.items():
            colour, dash = COLOURS[gas]
            centres.plot(series["time"], series["centre"], dash, color=colour, linewidth=1.1)
        for k, axis in enumerate(waves):
            for number, found in enumerate(runs):
                sizes = upright(found["amplitudes"])[:, k]
                axis.plot(found["time"], sizes, color=REDS[number], linewidth=0.8)
            for gas, series in flows.items():
                colour, dash = COLOURS[gas]
                axis.plot(series["time"], upright(series["amplitudes"])[:, k], dash, color=colour, linewidth=1.1)
            axis.axhline(0.0, color="0.8", linewidth=0.6, zorder=0)
        waves[-1].set_xlabel("$t\\,T_*^{1/2}/L_x$")
        walls.set_yscale("log")
    axes[0, 0].set_ylabel("largest and smallest\n$n(0,y)/n_c$")
    axes[1, 0].set_ylabel("mean $x/L_x$ of the grains")
    axes[1, 0].set_ylim(*SHOWN)
    axes[2, 0].set_ylabel("mean $\\cos(\\pi y/\\Delta)$")
    axes[3, 0].set_ylabel("mean $\\cos(2\\pi y/\\Delta)$")
    axes[1, 1].legend(*axes[0, 1].get_legend_handles_labels(), fontsize=8, loc="center right")
    return figure


def clustered(found: dict[str, Any]) -> Figure:
    """Grains near the elastic wall at the times of the deck, by cluster; the wall lies below."""
    shots, deck = found["saved"], found["deck"]
    figure = Figure(figsize=(9.5, 1.5 * len(shots) + 0.3), layout="constrained")
    for axis, saved in zip(figure.subplots(len(shots), sharex=True), shots, strict=True):
        grains = dynamics_again(deck, saved.memory)
        disks = disks_at(grains.places[:, ::-1], grains.arena.diameter)
        disks.set_offset_transform(axis.transData)
        axis.add_collection(disks)
        axis.set(xlim=(0.0, deck.box.aspect_ratio), ylim=(0.0, CLOSE), aspect="equal", ylabel="$x/L_x$")
        axis.set_title(f"$t = {saved.time:g}$", fontsize=10)
        by_cluster(axis, disks, grains)
    axis.set_xlabel("$y/L_x$")
    return figure


def averages(found: dict[str, Any]) -> list[Map]:
    """Density of a run of grains at the times of the deck, averaged over windows."""
    mesh = mesh_of(found["deck"])
    fields = [(saved.time, averaged(saved)[0]) for saved in found["saved"]]
    return [Map(n, mesh, f"$t = {time:g}$", CLUSTERING.span.note(n, mesh)) for time, n in fields]


def rows(results: dict[str, Any]) -> list[list[Any]]:
    """Wall densities of grains, averaged over windows, and of the flows, at the times of the decks."""
    lines = []
    for name, (runs, flows) in results.items():
        for shots in zip(*(found["shots"] for found in runs), strict=True):
            line, time = [name, f"{shots[0]['time']:g}"], shots[0]["time"]
            for key in ("wall_max", "wall_min"):
                line.append(over_seeds([shot[key] for shot in shots], shots[0][key + "_error"]))
                at = (np.interp(time, flow["time"], flow[key], right=math.nan) for flow in flows.values())
                line += [f"{value:.3f}" if value > 0.0 else "none" for value in at]
            lines.append(line)
    return lines


def first_time(times: np.ndarray, reached: np.ndarray) -> str:
    """When something is first so, of what is told at some times."""
    return f"{times[reached.argmax()]:.0f}" if reached.any() else "not"


def for_good(times: np.ndarray, reached: np.ndarray) -> str:
    """From when on something stays so."""
    return first_time(times, np.logical_and.accumulate(reached[::-1])[::-1])


def moments(results: dict[str, Any]) -> list[list[Any]]:
    """When the gas is dense somewhere, and when one side has won: of grains, of every seed, and of the flows."""
    lines = []
    for name, (runs, flows) in results.items():
        line = [
            (
                first_time(one["time"], one["wall_max"] > DENSE),
                for_good(one["time"], np.abs(one["amplitudes"][:, 0]) > WON),
            )
            for one in (*runs, *flows.values())
        ]
        dense, won = zip(*line, strict=True)
        count = len(runs)
        lines.append([name, ", ".join(dense[:count]), *dense[count:], ", ".join(won[:count]), *won[count:]])
    return lines


def boxes(results: dict[str, Any]) -> list[list[Any]]:
    """What the runs of grains are."""
    lines = []
    for name, (runs, _) in results.items():
        deck: Any = load(PROBLEMS / f"{BOXES[name].deck}.toml", BOXES[name].overrides)
        made, gas = runs[0]["summary"], matched(deck)
        lines.append([
            name, len(runs), made["grains"], f"{made['diameter']:.3g}", f"{1.0 - made['restitution'] ** 2:.3g}",
            f"{made['collisions']:.2e}", f"{made['soft_collisions'] / made['collisions']:.2%}",
            f"{gas.L:.3g}", f"{gas.K:.3g}",
        ])  # fmt: skip
    return lines


PAGE = """# Fig. 4 by grains

Printed by `python benchmarks/papers/grains_fig4.py docs > docs/grains_fig4.md`: the box of Fig. 4, f = 0.0235, from two
half-waves of 10%. "mu = 1" is `problems/grains_fig4.toml`, "matched" `problems/grains_matched.toml`, "large" the same
with larger grains ({changed}), where all is sooner.
"""

FIGURE = """
![Wall densities, mean x and amplitudes of cosines against time](grains_fig4.png)

*Grains (red, orange, brown: seeds; wall densities averaged over windows, which lowers the largest and lifts the
smallest where a cluster moves, and noise does the opposite) and two
hydrodynamics from the same start, {nx} x {ny} cells, with the viscosity of kinetic
theory, no rolling friction, and the wall that gives the same heat: "closures", those of the paper with the conduction
and the densities that dilute grains have (the last two columns above); "Enskog", Enskog's theory without a fitted
number. They start with an amplitude of one half-wave as large as the noise of the grains, (2/N)^(1/2): what is its own
mirror image would stay so. "none": the run has ended before, as its core came to close packing, where Enskog's theory
does not hold.*

![Density of the grains](grains_fig4_density.png)

*Density of the matched grains, averaged over windows.*

![The matched grains, coloured by cluster](grains_fig4_clusters.png)

*The matched grains next to the elastic wall, which lies below, by the cluster that they are in: grains with gaps below
0.3 d belong together. The numbers are those of the whole box.*
"""

MOMENTS = f"""
When the largest wall density first passes {DENSE:g}, and from when on the mean cos(pi y/Delta) is above {WON:g}: the
seeds one by one, and the flows.
"""

LATE = """
Means over the second half of each run of grains (absolute values of the cosines), beside the steady state of one
half-wave:
"""

VERDICT = """
The matched run has three clusters at t = 100, two at 500, of which one lies in a corner, and from t = 1000 at the
latest one in that corner. Its means over the second half are not those of an end.

**Two clusters do not last.** The paper's Fig. 4 ends in two, from a start that is its own mirror image. Grains are
not: one cluster takes the grains of the others, as the linear theory of that state wants it ([steady.md](steady.md)).
When that is so is chance: the third seed with mu = 1 has the smallest wall density of two clusters until t of some 600,
and then that of one, like the others from t = 300 on. The matched gas is on one side from t = 512 on.
Hydrodynamics that starts with the noise of the grains does the same with mu = 1; with the parameters of the others it
does not in that time, for there that mode grows slowly, after it has shrunk at first: the noise of grains goes on, and
is not that of their start alone.

**Grains are faster** than the closures, 3 to 12 times until the gas is dense on the wall, and than Enskog's theory, 1.4
to 6 times. Conduction alone would make 35 of the 14 of the large grains with the K of the matched ones, which take 82:
more grains, which lose less in a collision, are slower, but still five times as fast as the closures.

**Where they end** the closures have about the right state. Beside their half-wave at rest the grains are 12% (mu = 1)
and 14% (large) thinner at the driving wall, the smallest density on the elastic wall is 22% and 43% lower, mean x 7%
and 10% lower, the mean cosine 6% lower and 6% higher. With mu = 1 the cluster wanders along the wall, so that the
second cosine is 0.26 where it would be 0.36 at rest. The matched grains have wall densities of 1.01 and 0.0114 at t =
1000, of 1.01 and 0.0132 at t = 1290, where their half-wave at rest has 0.996 and 0.0115. (Densities above n_c: layers
of centres lie on the very edge of the first cells, which makes 5% for the large grains.) Enskog's theory has no state
to end in: its core passes freezing, where it does not hold, and goes on to close packing.

The large grains lose 8% of the energy of their relative motion in a collision, and at t = 330 their core collapsed in a
run without a contact time. It has been 1e-6 in all but those with mu = 1, and made few collisions elastic."""


def main() -> None:
    """Run what is missing, draw, print the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="for the pictures")
    parser.add_argument("--output", type=Path, default=Path("output/grains_fig4"))
    options = parser.parse_args()
    results = {}
    for name in BOXES:
        runs = [grains(options.output, name, seed) for seed in BOXES[name].seeds]
        number = runs[0]["summary"]["grains"]
        results[name] = runs, {gas: flow(name, gas_of, number) for gas, gas_of in GASES.items()}
    publish(draw(results), options.folder / "grains_fig4")
    (longest,) = results["matched"][0]
    density_panels(options.folder / "grains_fig4_density.png", averages(longest))
    save(clustered(longest), options.folder / "grains_fig4_clusters.png", dpi=200)
    print(PAGE.format(changed=", ".join(BOXES["large"].overrides[:2])))
    header = [
        "grains",
        "seeds",
        "number",
        "d/L_x",
        "1-r^2",
        "collisions",
        "made elastic",
        "conduct and are dense like L =",
        "K =",
    ]
    print(table(header, boxes(results)))
    print(FIGURE.format(nx=CELLS[0], ny=CELLS[1]))
    names = [f"{kind}, {who}" for kind in ("largest n(0, y)", "smallest n(0, y)") for who in ("grains", *GASES)]
    print(table(["grains", "t", *names], rows(results)))
    names = [f"{what}, {who}" for what in (f"n(0, y) > {DENSE:g}", "one side has won") for who in ("grains", *GASES)]
    print(MOMENTS)
    print(table(["grains", *names], moments(results)))
    print(LATE)
    lines = []
    for name, (runs, _) in results.items():
        lines.append([name, "grains", *late(runs)])
        lines += [["", f"{gas}, at rest", *at_rest(name, gas_of)] for gas, gas_of in GASES.items()]
    sizes = [f"mean cos({'2 ' * (m > 1)}pi y/Delta)" for m in WAVES]
    print(table(["grains", "", "largest n(0, y)", "smallest n(0, y)", "n at x = 1", "mean x", *sizes], lines))
    print(VERDICT)


if __name__ == "__main__":
    main()
