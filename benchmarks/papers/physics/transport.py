"""The constant mu of the paper's closures, from cooling and from conduction."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from hydro.gas import Grossman
from hydro.grains import theory
from hydro.grains.placement import CLOSE_PACKING
from hydro.markdown import table
from hydro.pictures.style import publish
from physics.bench import ALPHA, DILUTE_CONDUCTIVITY, GAMMA, Estimate, box_of_grains, estimate, kept, mean_free_path
from physics.enskog import SONINE, Enskog
from physics.slab import BINS, DEPTH, slab

DENSITIES, RESTITUTIONS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5), (0.999, 0.99, 0.98, 0.95, 0.9)
DILUTE, RESTITUTION = 0.05, 0.99  # where the other of the two varies
SEEDS = range(1, 7)
NUMBER, WARM, FALL = 2000, 10.0, 4.0  # grains; collisions of each before the start; fall of T from then on
# n of the slab: number of grains, and how long to measure
SLABS = {0.02: (2000, 300.0), 0.05: (1500, 300.0), 0.1: (1000, 300.0), 0.2: (800, 200.0), 0.3: (600, 200.0),
         0.4: (400, 150.0)}  # fmt: skip
SLAB_SEEDS = (1, 2, 3)
HOT = 3.0  # temperature of the wall; the reservoir has 1
PAPER_GAS, ENSKOG_GAS = Grossman(0.0, 1.0, ALPHA), Enskog(0.0, 1.0)


def cooling(n: float, restitution: float, number: int, seed: int) -> dict[str, Any]:
    """Haff's law: 1/T^(1/2) rises by (rate/2) t, where dT/dt = -rate T^(3/2)."""
    grains = box_of_grains(number, n, seed, restitution=restitution)
    rate = theory.cooling_rate(n, 1.0, grains.arena.diameter, restitution)
    grains.advance(WARM / theory.collision_rate(n, 1.0, grains.arena.diameter))
    start, seen = grains.time, []
    last = start + 2.0 * (math.sqrt(FALL) - 1.0) / rate
    for moment in np.linspace(start, last, 9).tolist():
        grains.advance(moment)
        seen.append((moment - start, grains.energy / (number - 1)))
    return {"times": [t for t, _ in seen], "temperatures": [T for _, T in seen], "diameter": grains.arena.diameter}


def cooling_mu(n: float, restitution: float) -> tuple[Estimate, Estimate]:
    """mu of I = (mu/(gamma l)) (1-r^2) n T^(3/2), and the ratio of the rates in the later and earlier half."""
    found, bent = [], []
    for seed in SEEDS:
        run = kept(cooling, n=n, restitution=restitution, number=NUMBER, seed=seed)
        t, root = np.array(run["times"]), np.array(run["temperatures"]) ** -0.5
        rate = 2.0 * (root[-1] - root[0]) / t[-1]
        found.append(GAMMA * mean_free_path(n, run["diameter"]) * rate / (1.0 - restitution**2))
        bent.append((root[-1] - root[4]) / (root[4] - root[0]))
    return estimate(found), estimate(bent)


def cooling_theory(n):
    """The same of Enskog's theory."""
    return GAMMA * mean_free_path(n, 1.0) * theory.cooling_rate(n, 1.0, 1.0, 0.0)


def conduction(n: float) -> dict[str, Any]:
    """From the middle of a slab: mu of the paper's conductivity, flux over that of Enskog, jump at the wall.

    q = kappa(n, T) dT/dx, with kappa/T^(1/2) averaged over the measured densities and T^(3/2) fitted by a line.
    jump: T of the wall less that of the line, over l dT/dx.
    """
    number, span = SLABS[n]
    runs = [
        kept(
            slab, wall="thermal", speed=math.sqrt(HOT), amplitude=0.0, n=n, number=number, length_y=1.0, warm=15.0,
            span=span, seed=seed,
        )
        for seed in SLAB_SEEDS
    ]  # fmt: skip
    diameter = runs[0]["diameter"]
    counts, energies, heat = (np.concatenate([run[key] for run in runs]) for key in ("counts", "energies", "heat"))
    x = (np.arange(BINS) + 0.5) / BINS
    path = mean_free_path(n, diameter)
    margin = max(3.0 * path, 1.5 * diameter, 1.5 / BINS)
    middle = (x > DEPTH + margin) & (x < 1.0 - margin)

    def found(chosen: Any) -> list[float]:
        density = counts[chosen].mean(axis=0) * BINS * diameter**2 / CLOSE_PACKING
        T = energies[chosen].sum(axis=0) / counts[chosen].sum(axis=0)
        slope, start = np.polyfit(x[middle], T[middle] ** 1.5, 1)
        q = heat[chosen].mean() * diameter / CLOSE_PACKING
        coefficients = [gas.conductivity_coefficient(density[middle]).mean() for gas in (PAPER_GAS, ENSKOG_GAS)]
        edge = (slope + start) ** (2.0 / 3.0)
        jump = (HOT - edge) / (mean_free_path(density[-1], diameter) * 2.0 / 3.0 * slope / math.sqrt(edge))
        return [*(q / (k * 2.0 / 3.0 * slope) for k in coefficients), jump, density[middle].mean()]

    rest = np.array([found(np.arange(len(heat)) != k) for k in range(len(heat))])
    of_seeds = np.array([found(part) for part in np.split(np.arange(len(heat)), len(runs))])
    scatter = of_seeds.std(axis=0, ddof=1) / math.sqrt(len(runs))
    errors = np.maximum(math.sqrt(len(heat) - 1) * rest.std(axis=0), scatter)
    names = ("mu", "enskog", "jump", "n")
    values = {
        name: Estimate(*pair) for name, pair in zip(names, zip(found(slice(None)), errors, strict=True), strict=True)
    }
    return values | {"paths": 1.0 / path, "diameters": 1.0 / diameter}


def conduction_theory(n):
    """mu that Enskog's conductivity gives the paper's."""
    return ENSKOG_GAS.conductivity_coefficient(n) / PAPER_GAS.conductivity_coefficient(n)


def weighted(estimates: list[Estimate]) -> Estimate:
    """The mean with weights 1/error^2."""
    weights = np.array([each.error**-2 for each in estimates])
    return Estimate(float(weights @ [each.value for each in estimates] / weights.sum()), float(weights.sum() ** -0.5))


PAGE = """## mu from cooling and from conduction

![mu from cooling and from conduction](grains_mu.png)

*(a) Haff's law at n = 0.05. (b) mu of the paper's closures, from grains (errors are below the size of most symbols)
and from Enskog's theory; dotted: dilute kinetic theory in lowest order, 1.42 and 2.41.*

**Cooling.** {number} grains in a periodic box, {seeds} seeds, after {warm:g} collisions of each until T has fallen
{fall:g}-fold. *later over earlier*: ratio of the rates `d T^(-1/2)/dt` of the two halves, 1 in Haff's law.
"""

SLAB = """
**Conduction.** Elastic grains between a reservoir at T = 1 and a thermal wall at T = {hot:g}, {seeds} seeds; errors
are the larger of those from blocks of time and from the scatter of the seeds. mu is that with which `kappa = (mu/l) n
(alpha l+d)^2 T^(1/2)` carries the measured heat down the measured gradient, in the middle, three mean free paths from
wall and reservoir. Enskog's conductivity is that of Gass (1971), `kappa = 1.029 (2/d) (T/pi)^(1/2) (1/chi + 3 phi +
3.487 phi^2 chi)`. *jump*: T of the thermal wall less that of the profile continued to it, over `l dT/dx`; Maxwell's
estimate for a dilute gas is 2.7.
"""

VERDICT = """
**In the dilute limit** mu = {cool} from cooling (kinetic theory: 1.416) and {conduct} from conduction (2.412 in
lowest order, 2.482 with the factor 1.029): each is the mean ratio of grains to Enskog's theory at n up to 0.1, times
the dilute value. They differ by the factor {ratio:.2f}, so a dilute gas of grains has the densities of {dilute:.2f}
L. The ratio for conduction falls from {long:.2f} to {short:.2f} as the slab gets shorter in mean free paths; 19 of them
may be too few, and then {conduct.value:.2f} is too low.

**Neither is a constant.** From n = 0.02 to 0.4 the mu of cooling rises from 1.44 to 2.1, that of conduction falls
from 2.3 to 1.3; they cross near n = {cross:.2f}. At n = 0.3 that is {dense:.2f} L, by Enskog's theory: in a cluster
they cool faster, beside their conduction, than the closures say. No mu, and no effective L, matches both a gas and
its cluster.

**Enskog's theory** describes cooling at r = 0.99 within {cool_off:.1f}% up to n = 0.5, where grains cool a little
more slowly, and conduction within {conduct_off:.1f}% up to n = 0.4. At n = 0.05 the mu of cooling falls by
{fall:.1f}% from r = 0.999 to 0.9.
"""


def section(folder: Path) -> str:
    """Draw, and return the text."""
    cooled = {n: cooling_mu(n, RESTITUTION) for n in DENSITIES}
    inelastic = {r: cooling_mu(DILUTE, r) for r in RESTITUTIONS}
    conducted = {n: conduction(n) for n in SLABS}
    publish(draw(cooled, conducted), folder / "grains_mu")
    rows = [
        [n, r, mu, f"{cooling_theory(n):.4f}", f"{mu.value / cooling_theory(n):.4f}", bent]
        for r, n, (mu, bent) in (
            *((RESTITUTION, n, each) for n, each in cooled.items()),
            *((r, DILUTE, each) for r, each in inelastic.items()),
        )
    ]  # fmt: skip
    slabs = [
        [f"{each['n'].value:.3f}", f"{each['paths']:.0f}", f"{each['diameters']:.0f}", each["mu"],
         f"{conduction_theory(each['n'].value):.3f}", each["enskog"], each["jump"]]
        for each in conducted.values()
    ]  # fmt: skip
    fine = np.linspace(0.01, 0.5, 500)
    cross = fine[np.argmin(np.abs(cooling_theory(fine) / conduction_theory(fine) - 1.0))]
    cool = weighted([
        Estimate(mu.value / cooling_theory(n), mu.error / cooling_theory(n))
        for n, (mu, _) in cooled.items() if n <= 0.1
    ])  # fmt: skip
    conduct = weighted([each["enskog"] for n, each in conducted.items() if n <= 0.1])
    weights = ((cool, theory.cooling_mu(GAMMA)), (conduct, SONINE * theory.conduction_mu(DILUTE_CONDUCTIVITY)))
    cool, conduct = (Estimate(each.value * mu, each.error * mu) for each, mu in weights)
    words = {
        "cool": cool, "conduct": conduct, "ratio": conduct.value / cool.value, "cross": cross,
        "dilute": cool.value / conduct.value, "dense": cooling_theory(0.3) / conduction_theory(0.3),
        "short": conducted[min(SLABS)]["enskog"].value, "long": conducted[0.1]["enskog"].value,
        "fall": 100.0 * (1.0 - inelastic[min(inelastic)][0].value / inelastic[max(inelastic)][0].value),
        "cool_off": 100.0 * max(abs(mu.value / cooling_theory(n) - 1.0) for n, (mu, _) in cooled.items()),
        "conduct_off": 100.0 * max(abs(each["enskog"].value - 1.0) for each in conducted.values()),
    }  # fmt: skip
    return "\n".join([
        PAGE.format(number=NUMBER, seeds=len(SEEDS), warm=WARM, fall=FALL),
        table(["n", "r", "mu", "Enskog", "grains over Enskog", "later over earlier"], rows),
        SLAB.format(hot=HOT, seeds=len(SLAB_SEEDS)),
        table(["n", "L_x/l", "L_x/d", "mu", "Enskog", "grains over Enskog", "jump"], slabs), "",
        VERDICT.format(**words),
    ])  # fmt: skip


def draw(cooled: dict[float, Any], conducted: dict[float, Any]) -> Figure:
    """T^(-1/2) against time, and both mu against n."""
    figure = Figure(figsize=(8.5, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    for r, color in zip(RESTITUTIONS, ("black", "tab:blue", "tab:green", "tab:orange", "tab:red"), strict=True):
        for seed in SEEDS:
            run = kept(cooling, n=DILUTE, restitution=r, number=NUMBER, seed=seed)
            t = np.array(run["times"]) * theory.cooling_rate(DILUTE, 1.0, run["diameter"], r)
            root = np.sqrt(run["temperatures"][0] / np.array(run["temperatures"]))
            start = math.sqrt(run["temperatures"][0])
            left.plot(t * start, root, ".", color=color, ms=3, label=f"$r={r:g}$" if seed == SEEDS[0] else None)
    line = np.array([0.0, 2.2])
    left.plot(line, 1.0 + 0.5 * line, color="0.5", linewidth=0.8, zorder=0, label="Enskog")
    left.set_xlabel(r"$t\,\times$ initial cooling rate")
    left.set_ylabel("$(T(0)/T)^{1/2}$")
    fine = np.linspace(0.002, 0.5, 200)
    look = {"fmt": "o", "ms": 4, "mfc": "white"}
    right.plot(fine, cooling_theory(fine), color="tab:blue", linewidth=0.9)
    right.plot(fine, conduction_theory(fine), color="tab:red", linewidth=0.9)
    right.errorbar(
        list(cooled), *zip(*(mu for mu, _ in cooled.values()), strict=True), color="tab:blue", label="cooling", **look
    )
    points = conducted.values()
    right.errorbar([each["n"].value for each in points], *zip(*(each["mu"] for each in points), strict=True),
                   color="tab:red", label="conduction", **look)  # fmt: skip
    right.plot([], [], color="0.4", linewidth=0.9, label="Enskog")
    for level in (theory.cooling_mu(GAMMA), theory.conduction_mu(DILUTE_CONDUCTIVITY)):
        right.axhline(level, color="0.6", linestyle=":", linewidth=0.8, zorder=0)
    right.set_xlabel("$n/n_c$")
    right.set_ylabel(r"$\mu$")
    right.set_xlim(0.0, 0.52)
    right.set_ylim(1.0, 2.7)
    for axis, title in ((left, "(a)  Haff's law"), (right, r"(b)  $\mu$")):
        axis.set_title(title, fontsize=10)
        axis.legend(fontsize=8)
    return figure
