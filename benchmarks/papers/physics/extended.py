"""Profiles of the extended state, grains on top of hydrodynamics."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from hydro.deck import load
from hydro.gas import Grossman
from hydro.grains import books, theory
from hydro.grains.integrator import dynamics_of
from hydro.grains.placement import CLOSE_PACKING
from hydro.initial import initial_state
from hydro.markdown import table
from hydro.pictures.style import publish
from hydro.steady.extended import ExtendedState, extended_state
from hydro.walls import VibratingWall
from physics.bench import ALPHA, DILUTE_CONDUCTIVITY, GAMMA, Estimate, estimate, kept
from physics.enskog import Enskog

DECK = Path(__file__).parents[3] / "problems" / "grains_extended.toml"
BINS, INTERVAL, FINE = 25, 0.5, 8
SEEDS = range(1, 5)
WARM, END = 60.0, 200.0
SUPPLY = 0.6  # K W = (2/pi)^(1/2) A^2 omega^2/T_*


def profiles(overrides: list[str], warm: float, seed: int) -> dict[str, Any]:
    """n and T in strips along x, averaged from `warm` to the end of the deck's run."""
    deck: Any = load(DECK, [*overrides, f"grains.seed={seed}"])
    grains = dynamics_of(deck, initial_state(deck))
    grains.advance(warm)
    edges, counts, energies = np.linspace(0.0, 1.0, BINS + 1), np.zeros(BINS), np.zeros(BINS)
    looks, gained, lost = (
        round((deck.time.end - warm) / INTERVAL),
        grains.sum(books.WALL_ENERGY),
        grains.sum(books.LOSS),
    )
    for _ in range(looks):
        grains.advance(grains.time + INTERVAL)
        x, kinetic = grains.positions[:, 0], 0.5 * (grains.velocities**2).sum(axis=1)
        counts += np.histogram(x, edges)[0]
        energies += np.histogram(x, edges, weights=kinetic)[0]
    area = deck.box.aspect_ratio / BINS * 2.0 / math.sqrt(3.0) / deck.gas.diameter**2
    return {
        "n": (counts / looks / area).tolist(), "T": (energies / counts).tolist(), "grains": grains.number,
        "collisions": grains.count(books.COLLISIONS), "gained": grains.sum(books.WALL_ENERGY) - gained,
        "lost": grains.sum(books.LOSS) - lost,
    }  # fmt: skip


class Case(NamedTuple):
    """A deck of grains, mu = 1."""

    L: float
    f: float
    diameter: float
    aspect_ratio: float

    @property
    def loss(self) -> float:
        """1-r^2."""
        return 3.0 * GAMMA / 32.0 * self.L * self.diameter**2

    @property
    def overrides(self) -> list[str]:
        """Of the deck; A omega is the same for all."""
        K = self.diameter
        return [
            f"gas.L={self.L:g}", f"gas.f={self.f:g}", f"gas.K={K:g}", "gas.mu=1", f"wall.W={SUPPLY / K:.17g}",
            f"box.aspect_ratio={self.aspect_ratio:g}", f"time.end={END:g}", f"output.times=[{END:g}]",
        ]  # fmt: skip


CASES = (
    Case(2000.0, 0.1, 0.02, 0.5), Case(2000.0, 0.1, 0.01, 0.5), Case(2000.0, 0.1, 0.005, 0.25),
    Case(500.0, 0.1, 0.01, 0.5), Case(8000.0, 0.1, 0.01, 0.5), Case(8000.0, 0.1, 0.005, 0.25),
    Case(2000.0, 0.03, 0.01, 0.5), Case(2000.0, 0.25, 0.01, 0.5),
)  # fmt: skip

# L over that of the deck, and K over d/L_x, of hydrodynamics beside the grains
MU_COOLING, MU_CONDUCTION = theory.cooling_mu(GAMMA), theory.conduction_mu(DILUTE_CONDUCTIVITY)
FAR = 0.4  # x beyond which there is gas, in the cases that differ in 1-r^2 alone
SAME = 3  # cases from the first on that do
SHOWN = (2, 3, 5, 7)  # cases that are drawn
LOOKS = {"the deck": ("tab:blue", "--"), "matched": ("tab:green", "-."), "Enskog": ("black", "-")}


def hydrodynamics(case: Case) -> dict[str, ExtendedState]:
    """The 1D state with the closures of the paper, at the L of the deck and at that of dilute grains, and of Enskog."""
    d = case.diameter
    gases = {
        "the deck": Grossman(case.L, d, ALPHA),
        "matched": Grossman(case.L * MU_COOLING / MU_CONDUCTION, d * MU_CONDUCTION, ALPHA),
        "Enskog": Enskog(case.L, d),
    }
    return {name: extended_state(gas, case.f) for name, gas in gases.items()}


def over_strips(field: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Averages of a function of x over the strips."""
    fine = (np.arange(BINS * FINE) + 0.5) / (BINS * FINE)
    return field(fine).reshape(BINS, FINE).mean(axis=1)


class Comparison(NamedTuple):
    """Profiles of the grains, (seeds, BINS), beside those of hydrodynamics, (BINS,) by name; heat per area and time."""

    case: Case
    n: np.ndarray
    T: np.ndarray
    gained: np.ndarray
    lost: np.ndarray
    number: int
    states: dict[str, ExtendedState]

    @classmethod
    def of(cls, case: Case) -> Comparison:
        runs = [kept(profiles, overrides=case.overrides, warm=WARM, seed=seed) for seed in SEEDS]
        n, T, gained, lost = (np.array([run[key] for run in runs]) for key in ("n", "T", "gained", "lost"))
        scale = (END - WARM) * case.aspect_ratio * CLOSE_PACKING / case.diameter**2
        return cls(case, n, T, gained / scale, lost / scale, runs[0]["grains"], hydrodynamics(case))

    def books(self) -> tuple[Estimate, Estimate, Estimate]:
        """Loss over Enskog's for the profiles; heat over the law with n at the wall, and with p/T in its place."""
        gas: Any = self.states["Enskog"].gas
        n, T = self.n[:, -1], self.T[:, -1]
        law = SUPPLY * n * np.sqrt(T)
        return (
            estimate(self.lost / gas.cooling(self.n, self.T).mean(axis=1)), estimate(self.gained / law),
            estimate(self.gained / law / gas.compressibility(n)),
        )  # fmt: skip

    def knudsen(self) -> float:
        """The largest mean free path over the length on which T of the grains changes."""
        n, T = self.n.mean(axis=0), self.T.mean(axis=0)
        path: Any = self.states["Enskog"].gas.mean_free_path(n) * self.case.diameter
        return float(np.max(path * np.gradient(np.log(T), 1.0 / BINS)))

    def wall(self, name: str) -> VibratingWall:
        """The wall that gives the heat of the deck's; in Enskog's theory, for contacts with a wall of density p/T."""
        state = self.states[name]
        contact = state.gas.compressibility(state.wall_density[1]) if name == "Enskog" else 1.0
        return VibratingWall(strength=contact * SUPPLY)

    def strips(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """n, and T weighted with n, of hydrodynamics in the strips of the grains."""
        state = self.states[name]
        n = over_strips(state.density_at)
        return n, over_strips(lambda x: state.density_at(x) * state.temperature_at(x, self.wall(name))) / n

    def distances(self, name: str) -> tuple[float, float]:
        """L1 distance of n over f, and rms of the logarithm of T over T, weighted with n."""
        n, T = self.strips(name)
        mean = self.n.mean(axis=0)
        ratio = np.log(self.T.mean(axis=0) / T)
        return float(np.abs(mean - n).mean() / self.case.f), float(np.sqrt((mean * ratio**2).sum() / mean.sum()))

    def noise(self) -> float:
        """What the first distance would be from statistical errors alone."""
        error = self.n.std(axis=0, ddof=1) / math.sqrt(len(self.n))
        return float(math.sqrt(2.0 / math.pi) * error.mean() / self.case.f)

    def fitted(self) -> tuple[float, float]:
        """The L with which the closures of the paper come closest to the densities, and the distance left."""
        from scipy.optimize import minimize_scalar

        mean = self.n.mean(axis=0)

        def distance(log_L: float) -> float:
            state = extended_state(Grossman(math.exp(log_L), 1.0, ALPHA), self.case.f)
            return float(np.abs(over_strips(state.density_at) - mean).mean() / self.case.f)

        center = math.log(self.case.L)
        best = minimize_scalar(distance, bounds=(center - 1.5, center + 1.5), method="bounded", options={"xatol": 1e-3})
        return math.exp(best.x), float(best.fun)


PAGE = """## Profiles of the extended state

![Profiles of the extended state](grains_profiles.png)

*Circles: grains, mean of {seeds} seeds; errors are smaller than the symbols. Lines: the 1D state with the closures of
the paper at the L of the deck (dashed), with those matched to dilute grains (dash-dotted), and with Enskog's
coefficients (solid). Nothing is fitted.*

The deck is `problems/grains_extended.toml` at mu = 1 with other `gas.L`, `gas.f`, `gas.K`, `box.aspect_ratio`; the
wall is `random-phase` with K W = {supply:g} throughout, so that A omega = 0.87 T_*^(1/2). All boxes are shorter than
the threshold. Averages are over t = {warm:g} to {end:g}, in {bins} strips, and {seeds} seeds. Beside them:

- *the deck*: closures of the paper with the `L` and `K` of the deck, mu = 1 in both;
- *matched*: the same closures with mu = 1.42 for cooling and 2.41 for conduction, those of dilute grains: 0.59 L,
  2.41 K;
- *Enskog*: Henderson's pressure, Enskog's cooling, Gass's conductivity for disks of this d and r, and a wall that is
  met by p/T, the density of centres at contact with it, in place of n.

The densities know nothing of the wall's law and of mu, but of mu of cooling over mu of conduction. Distances are
those of the strips: `int |n - n_h| dx/f`, and the root mean square of `log(T/T_h)` weighted with n. *noise* is what
statistical errors alone make of the first; *fitted* the L at which the closures of the paper come closest to the
densities, and *left* the distance then. A strip at a wall may hold more than n_c: layers of centres lie on its very
edge.
"""


def section(folder: Path) -> str:
    """Draw, and return the text."""
    found = [Comparison.of(case) for case in CASES]
    publish(draw([found[k] for k in SHOWN]), folder / "grains_profiles")
    named = ["L", "f", "1-r^2", "d/L_x"]
    ends, rows = [], []
    for each in found:
        first = [f"{each.strips(name)[0][0]:.3f}" for name in LOOKS]
        lost, law, contact = each.books()
        ends.append(
            [*name_of(each), each.number, f"{each.knudsen():.2f}", estimate(each.n[:, 0]), *first, lost, law, contact]
        )
        L, left = each.fitted()
        distances = [f"{100.0 * n:.1f}%, {100.0 * T:.0f}%" for n, T in map(each.distances, LOOKS)]
        noise = f"{100.0 * each.noise():.1f}%"
        rows.append([*name_of(each), *distances, noise, f"{L / each.case.L:.2f} L", f"{100.0 * left:.1f}%"])
    ahead = [
        *named,
        "grains",
        "Kn",
        "n, first strip",
        *LOOKS,
        "loss over Enskog",
        "heat over the law",
        "with p/T for n",
    ]
    page = PAGE.format(seeds=len(SEEDS), supply=SUPPLY, warm=WARM, end=END, bins=BINS)
    distances_table = table([*named, *LOOKS, "noise", "fitted", "left"], rows)
    verdict = VERDICT.format(**differences(found))
    return "\n".join([page, "Distances of n, of T:\n", distances_table, KNUDSEN, table(ahead, ends), "", verdict])


def differences(found: list[Comparison]) -> dict[str, Any]:
    """What the verdict says of temperatures, and of the first cases, which differ in 1-r^2 alone: beside Enskog's."""
    gas, alike = (np.arange(BINS) + 0.5) / BINS > FAR, found[:SAME]
    hot = [each.strips("the deck")[1][-1] / each.T.mean(axis=0)[-1] for each in found]
    ratios = [each.T.mean(axis=0) / each.strips("Enskog")[1] for each in alike]
    weights = [each.n.mean(axis=0)[gas] for each in alike]
    cold = [1.0 - np.average(ratio[gas], weights=weight) for ratio, weight in zip(ratios, weights, strict=True)]
    lack = [1.0 - each.n.mean(axis=0)[-1] / each.strips("Enskog")[0][-1] for each in alike]
    return {
        "hot": (min(hot), max(hot)), "far": FAR, "cold": percents(cold), "lack": percents(lack),
        "kn": listed([f"{each.knudsen():.2f}" for each in alike]),
        "hotter": f"{100.0 * (max(ratio[~gas].max() for ratio in ratios) - 1.0):.0f}%",
    }  # fmt: skip


def percents(values: list[Any]) -> str:
    """28%, 10% and 6%."""
    return listed([f"{100.0 * value:.0f}%" for value in values])


def listed(words: list[str]) -> str:
    """a, b and c."""
    return f"{', '.join(words[:-1])} and {words[-1]}"


KNUDSEN = """
Kn is the largest mean free path over the length on which T changes. Loss and heat are those of the books, over those
that follow from the measured profiles.
"""


def name_of(each: Comparison) -> list[str]:
    """What tells a case from others."""
    case = each.case
    return [f"{case.L:g}", f"{case.f:g}", f"{case.loss:.3f}", f"{case.diameter:g}"]


def draw(found: list[Comparison]) -> Figure:
    """n above T."""
    figure = Figure(figsize=(11.0, 5.6), layout="constrained")
    axes = figure.subplots(2, len(found), sharex=True)
    x, fine = (np.arange(BINS) + 0.5) / BINS, np.linspace(0.0, 1.0, 300)
    for number, (column, each) in enumerate(zip(axes.T, found, strict=True)):
        for axis, field in zip(column, (each.n, each.T), strict=True):
            error = field.std(axis=0, ddof=1) / math.sqrt(len(field))
            axis.errorbar(x, field.mean(axis=0), error, fmt="o", ms=3.5, mfc="white", color="tab:red", label="grains")
        for name, (color, dash) in LOOKS.items():
            state = each.states[name]
            column[0].plot(fine, state.density_at(fine), dash, color=color, linewidth=1.0, label=name)
            column[1].plot(fine, state.temperature_at(fine, each.wall(name)), dash, color=color, linewidth=1.0)
        case = each.case
        title = rf"({'abcd'[number]})  $\mathcal{{L}}={case.L:g}$, $f={case.f:g}$, $1-r^2={case.loss:.3f}$"
        column[0].set_title(title, fontsize=10)
        column[1].set_xlabel("$x/L_x$")
        for axis in column:
            axis.set_yscale("log")
            axis.set_xlim(0.0, 1.0)
    axes[0, 0].set_ylabel("$n/n_c$")
    axes[1, 0].set_ylabel("$T/T_*$")
    axes[0, 0].legend(fontsize=8)
    return figure


VERDICT = """
**Which L.** The closures of the paper come closest to the densities at 0.7 L where the gas is dilute (f = 0.03), at
0.8 L at f = 0.1, L = 500 and 2000, and at the L of the deck or more where there is a cluster (L = 8000; f = 0.25).
Kinetic theory says the same: mu of cooling over mu of conduction is 0.59 in the dilute limit and 1 at n = 0.15. So
the deck's own L with mu = 1 describes densities within 4% to 8% of the mass everywhere, the matched 0.59 L only where
the gas is dilute: within 2% at f = 0.03, no better than 20% where there is a cluster. T knows each mu: with mu = 1
the gas at the driving wall comes out {hot[0]:.1f} to {hot[1]:.1f} times as hot as grains are; matched, T is within 6%
at L = 500 and f = 0.03.

**Where hydrodynamics holds.** With Enskog's coefficients, and nothing fitted, densities are within 1.5% at L = 500
and at f = 0.03 (1-r^2 = 0.01 and 0.04) and T within 3%; within 5% for all other cases with 1-r^2 up to 0.04. At L =
2000, f = 0.1, the gas (x > {far:g}) is colder than hydrodynamics says by {cold} at 1-r^2 = 0.17, 0.042 and 0.011: in
proportion to Kn = {kn}, that is to (1-r^2)^(1/2). The lack of grains at the driving wall falls likewise ({lack}). What
does not fall with Kn is a cluster that is 6% less dense at x = 0 than Enskog's, and up to {hotter} hotter; its
conductivity, measured above, is a few percent higher than his at n = 0.2 to 0.3, which has this sign. At f = 0.25 the
cluster is a crystal, where his theory ends: it loses a sixth less heat.

**The wall.** `random-phase` gives 2% to 14% more than the law with n at the wall. With p/T for n this is up to 6%, and
no more than the errors in the two gases of 1-r^2 = 0.17.
"""
