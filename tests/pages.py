"""Numbers that pages print and that are cheap to compute: what computes them, by name.

A page marks a paragraph or a table with `<!-- computed: NAME -->` on the line before it, or a block of code with
`<!-- printed: COMMAND -->`; `tests/test_pages.py` computes it again and looks whether the page says the same. A
function here returns texts, numbers in the digits and the words of the page, each of which has to stand in what is
marked.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from hydro.deck import load
from hydro.gas import Grossman
from hydro.kinds.run import run_in
from hydro.mesh import Mesh
from hydro.output.folder import RunFolder
from hydro.setup import gas_of, mesh_of, wall_of
from hydro.steady.extended import extended_state
from hydro.steady.growth import growth_of
from hydro.steady.localized import steady_state
from hydro.steady.marginal import Tongue, critical_aspect_ratio, tongue
from hydro.walls import VibratingWall

PROBLEMS = Path(__file__).parent.parent / "problems"
GAS = Grossman(L=5e4, K=2e-3)
GRIDS = ("64 x 128", "128 x 256")
COMPUTED: dict[str, Callable[[], list[str]]] = {}

# Pages without a mark, and why: what their numbers take.
NOT_RERUN = {
    "architecture.md": "no numbers",
    "branches.md": "written by a program, half an hour",
    "calibration.md": "written by a program, hours",
    "campaigns.md": "minutes to an hour for each of its studies",
    "coarsening.md": "written by a program, a minute",
    "compare.md": "its runs take minutes",
    "decks.md": "written by a program; test_readme.py writes it again",
    "extending.md": "test_readme.py runs its programs; it prints no results",
    "fig3.md": "written by a program, minutes",
    "fig4.md": "written by a program, hours",
    "free_cooling.md": "its runs and its forty starts take minutes",
    "grains.md": "its runs take minutes",
    "grains_fig4.md": "written by a program, hours",
    "grains_physics.md": "written by a program, hours",
    "looking.md": "test_looking.py runs its programs; it prints no results",
    "map.md": "written by a program, half an hour",
    "performance.md": "written by a program; times are those of a machine",
    "running.md": "no results",
    "verification.md": "written by a program, hours; test_verification.py runs its cheap claims",
}


def computed(function: Callable[[], list[str]]) -> Callable[[], list[str]]:
    """Enter the function under its name."""
    COMPUTED[function.__name__] = function
    return function


def steady_rate(wave: int, cells: tuple[int, int], aspect_ratio: float, sector: str, viscosity: float) -> float:
    """The leading growth rate of a steady state of L = 5e4, f = 0.0235, K = 2e-3, tau = 200 in a sector."""
    mesh = Mesh.rectangle(cells, aspect_ratio)
    steady = steady_state(GAS, VibratingWall(strength=0.228), mesh, 0.0235, wave)
    return next(each.rate for each in growth_of(steady, 200.0, 1, viscosity) if each.sector == sector)


@computed
def viscous_growth() -> list[str]:
    """How viscosity changes growth rates, on 32 cells in x."""
    cases = [(0, (32, 32), 1.0, "1 half-wave"), (2, (32, 64), 2.0, "antisymmetric"), (1, (32, 32), 1.0, "all")]
    extended, exchange, decay = (steady_rate(*case, 1.0) / steady_rate(*case, 0.0) for case in cases)
    return [
        f"the extended one grows {extended:.1f} times as fast",
        f"the exchange of mass between two clusters {exchange:.1f} times",
        f"perturbations of one cluster decay {decay:.1f} times as fast",
    ]


@computed
def sound_of_a_cluster() -> list[str]:
    """The slowest decay of sound around one cluster, on 20 x 20 cells."""
    steady = steady_state(GAS, VibratingWall(strength=0.228), Mesh.rectangle((20, 20)), 0.0235, 1)
    (growth,) = growth_of(steady, 200.0, 8)
    slowest = max(mode.growth_rate.real for mode in growth.modes if mode.growth_rate.imag > 1.0)
    return [f"({-slowest:.2f} per unit time around one cluster on 20 x 20 cells"]


@computed
def ratios_of_viscosities() -> list[str]:
    """Extremes of eta/kappa and zeta/kappa."""
    n = np.linspace(1e-6, 1.0 - 1e-6, 4001)
    eta, zeta = (each / GAS.conductivity(n, 1.0) for each in GAS.viscosities(n, np.ones_like(n)))
    least = n[np.argmin(eta)]
    return [
        f"{eta.min():.3f} at least (near `n = {least:.2f}`)",
        f"{eta[-1]:.4f}\nat close packing",
        f"to {zeta[-1]:.3f}",
    ]


def table_row(*entries: Any) -> str:
    """A row of a Markdown table."""
    return "| " + " | ".join(map(str, entries)) + " |"


@cache
def tongue_of(L: float, wall: str) -> Tongue:
    """The tongue before a wall; densities do not depend on K."""
    return tongue(Grossman(L=L, K=1.0), wall)


@computed
def tongues() -> list[str]:
    """Two rows of the table; the others take longer."""
    rows = []
    for wall in ("vibrating", "thermal"):
        found = tongue_of(5e4, wall)
        ends = [f"{value:.7g}" for value in (found.f1, found.f2, found.f_min, found.aspect_ratio_min)]
        ends[0] = powers(f"{found.f1:.6e}") if found.f1 < 1e-3 else ends[0]
        rows.append(table_row("5e4", wall, *ends, f"{found.aspect_ratio_min * math.sqrt(5e4):.7g}"))
    return rows


def powers(text: str) -> str:
    """1.5e-04 as 1.5e-4."""
    return text.replace("e-0", "e-")


@computed
def first_point() -> list[str]:
    """Where points 1 and 2 of Fig. 2 lie."""
    ratio = critical_aspect_ratio(extended_state(GAS, 0.0235), "vibrating").aspect_ratio
    assert ratio is not None
    found = tongue_of(5e4, "vibrating"), tongue_of(5e4, "thermal")
    return [
        f"`Delta_1(0.0235) = {ratio:.5f}`",
        f"`{powers(f'{found[0].f1:.4e}')} < f < {found[0].f2:.6f}`",
        f"`{found[1].f1:.7f} < f < {found[1].f2:.6f}`",
        f"{found[0].aspect_ratio_min:.5f} at `f = {found[0].f_min:.6f}`",
    ]


@cache
def rate_of_experiment(deck: str) -> float:
    """The growth rate of a half-wave on the stripe of an experiment, square cells, 32 of them in x."""
    words = [f"mesh.cells=[32,{32 if deck.endswith('stable') else 64}]"]
    evolution = load(PROBLEMS / f"{deck}.toml", words)
    extended = steady_state(gas_of(evolution), wall_of(evolution), mesh_of(evolution), evolution.gas.f, 0)
    return next(each.rate for each in growth_of(extended, evolution.gas.tau, 1) if each.sector == "1 half-wave")


@computed
def experiments() -> list[str]:
    """Growth rates of both experiments, 32 cells in x."""
    decks = ("experiment", "experiment_stable")
    return [f"| growth rate, {deck} | {rate_of_experiment(deck):.5f} |" for deck in decks]


@computed
def experiment_in_words() -> list[str]:
    """What the page says of the first experiment."""
    return [f"{rate_of_experiment('experiment'):.4f} per unit of time"]


@computed
def least_aspect_ratios() -> list[str]:
    """Least aspect ratios for some L, over L^(-1/2)."""
    least = {L: tongue_of(L, "vibrating").aspect_ratio_min * math.sqrt(L) for L in (1e3, 2.3e3, 1e4, 1e6)}
    return [
        f"{least[1e6]:.2f} in the limit of large `L`; {least[1e4]:.1f} at `L = 1e4`, "
        f"{least[2.3e3]:.1f} (the least) at 2.3e3, {least[1e3]:.1f} at 1e3"
    ]


@computed
def steps_in_fig4() -> list[str]:
    """Steps and seconds as docs/fig4.md has them, which a program writes."""
    implicit, explicit = (PROBLEMS.parent / "docs" / "fig4.md").read_text(encoding="utf-8").split("## The explicit")
    ours, theirs, fitted = (
        [
            line.strip("| ").split(" | ")[-2:]
            for grid in GRIDS
            for line in text.splitlines()
            if line.startswith(f"| {grid}{kind} |")
        ]
        for text, kind in ((implicit, ""), (explicit, ""), (implicit, ", as fitted"))
    )
    (steps, seconds), (fine_steps, fine_seconds) = ours
    (many, long), (more, longer) = theirs
    return [
        f"it takes {steps} steps on 64 x 128 cells instead of {many}, {seconds} s instead of {long} s",
        f"{fine_steps} steps and {fine_seconds} s instead of {more} and {longer} s",
        f"{fitted[0][0]} and {fitted[1][0]} steps",
    ]


@computed
def viscous_fig4() -> list[str]:
    """Fig. 4 on 32 x 64 cells, with viscosity and without."""
    return [table_row(viscosity, *densities_of_fig4(viscosity)) for viscosity in (0, 1)]


def densities_of_fig4(viscosity: float) -> list[str]:
    """Largest and smallest density of the wall at four times of Fig. 4."""
    words = [f"gas.viscosity={viscosity}", "mesh.cells=[32,64]", "output.pictures=false"]
    deck = load(PROBLEMS / "fig4.toml", [*words, "output.times=[100,500,1000,1290]"])
    with tempfile.TemporaryDirectory() as name:
        summary = run_in(RunFolder(Path(name)), deck, overwrite=True, quiet=True)
    return [f"{row['wall_max']:.2f}, {row['wall_min']:.3f}" for row in summary["snapshots"]]
