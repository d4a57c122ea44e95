"""Pressure and collision rate of elastic disks, against accurate values and the closure of the paper."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from hydro.gas import Grossman
from hydro.grains import books, theory
from hydro.markdown import table
from hydro.pictures.style import publish
from physics.bench import ALPHA, Estimate, box_of_grains, estimate, kept

DENSITIES = (0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.65, 0.7, 0.75)
NUMBER, WARM, COLLISIONS, BLOCKS = 2000, 200.0, 1000.0, 10  # collisions of a grain, before and while measuring
# B_k/B_2^(k-1), k = 2 to 10, of hard disks (Clisby and McCoy, J. Stat. Phys. 122, 15, 2006)
VIRIAL = (1.0, 0.782004433, 0.53223180, 0.33355604, 0.1988425, 0.1148728, 0.0649930, 0.0362193, 0.0199537)


def elastic(n: float, number: int, warm: float, collisions: float, seed: int) -> dict[str, Any]:
    """Z = p/(n T) and collisions of a grain in unit time, at T = 1, in blocks."""
    grains = box_of_grains(number, n, seed)
    rate = theory.collision_rate(n, 1.0, grains.arena.diameter)
    grains.advance(warm / rate)
    span, found = collisions / rate / BLOCKS, []
    temperature = grains.energy / (number - 1)  # momentum is zero
    for _ in range(BLOCKS):
        count, virial = grains.count(books.COLLISIONS), grains.sum(books.VIRIAL)
        grains.advance(grains.time + span)
        compressibility = 1.0 + 0.5 * (grains.sum(books.VIRIAL) - virial) / (span * grains.energy)
        hits = 2.0 * (grains.count(books.COLLISIONS) - count) / (number * span)
        found.append((compressibility, hits / temperature**0.5))
    Z, rates = zip(*found, strict=True)
    return {"Z": Z, "rate": rates, "diameter": grains.arena.diameter}


def pade(n):
    """Z from the ten virial coefficients that are known, as the quotient of polynomials of degrees 4 and 5."""
    series = np.concatenate([[1.0], VIRIAL])  # in powers of 2 phi
    below, above = 5, 4
    rows = range(above + 1, above + below + 1)
    matrix = [[series[row - k] if row >= k else 0.0 for k in range(1, below + 1)] for row in rows]
    q = np.concatenate([[1.0], np.linalg.solve(matrix, -series[above + 1 :])])
    p = [sum(q[k] * series[m - k] for k in range(m + 1)) for m in range(above + 1)]
    y = 2.0 * theory.covered(np.asarray(n))
    return np.polyval(p[::-1], y) / np.polyval(q[::-1], y)


def enskog_rate(n, diameter):
    """Collisions of a grain in unit time at T = 1, with the contact value of the accurate pressure."""
    contact = (pade(n) - 1.0) / (2.0 * theory.covered(n))
    return theory.collision_rate(n, 1.0, diameter) / theory.contact_value(n) * contact


PAGE = """## Equation of state and collision rate

![Pressure of disks and of the closure](grains_state.png)

*(a) p/(n T) of elastic grains, errors far below the symbols; (b) differences from the virial series.*

{number} elastic grains in a periodic box, one seed, errors from {blocks} blocks of time, {collisions:g} collisions of
each grain in all. *series*: the [4/5] Padé approximant of the virial series to the tenth coefficient (Clisby and
McCoy, 2006). *Henderson*: `(1+phi^2/8)/(1-phi)^2`, as in `hydro/grains/theory.py`. *the paper*: Eq. (state),
`(1+n)/(1-n)`. Enskog's rate of collisions has the contact value that belongs to the pressure of the series. Disks
freeze near n = 0.77.
"""

VERDICT = """
Up to n = 0.7 the pressure of the grains is that of the series within {agree:.2f}%, and their rate of collisions
Enskog's within {rate:.2f}%. At 0.75, next to freezing, of which a series knows nothing, they are lower by
{freezing:.1f}% and {slower:.1f}%. Eq. (state) is within 1% up to n = 0.2, and low by {third:.1f}% at 0.3, {half:.0f}%
at 0.5, {seven:.0f}% at 0.7.
"""


def section(folder: Path) -> str:
    """Draw, and return the text."""
    found = {
        n: kept(elastic, n=n, number=NUMBER, warm=WARM, collisions=COLLISIONS, seed=1) for n in DENSITIES
    }  # fmt: skip
    Z = {n: estimate(each["Z"]) for n, each in found.items()}
    rates = {n: relative(estimate(each["rate"]), enskog_rate(n, each["diameter"])) for n, each in found.items()}
    publish(draw(Z), folder / "grains_state")
    paper = {n: (1.0 + n) / (1.0 - n) / Z[n].value - 1.0 for n in DENSITIES}
    rows = [
        [n, Z[n], f"{percent(Z[n].value / pade(n) - 1.0)}", percent(Z[n].value / theory.compressibility(n) - 1.0),
         percent(paper[n]), rates[n]]
        for n in DENSITIES
    ]  # fmt: skip
    header = ["n", "p/(n T)", "less series", "less Henderson", "the paper less grains", "collisions over Enskog"]
    fluid = [n for n in DENSITIES if n <= 0.7]
    shares = {
        "agree": max(abs(Z[n].value / pade(n) - 1.0) for n in fluid),
        "rate": max(abs(rates[n].value - 1.0) for n in fluid),
        "freezing": 1.0 - Z[0.75].value / pade(0.75), "slower": 1.0 - rates[0.75].value,
        "third": -paper[0.3], "half": -paper[0.5], "seven": -paper[0.7],
    }  # fmt: skip
    return "\n".join([
        PAGE.format(number=NUMBER, blocks=BLOCKS, collisions=COLLISIONS), table(header, rows), "",
        VERDICT.format(**{key: 100.0 * value for key, value in shares.items()}),
    ])  # fmt: skip


def relative(found: Estimate, to: float) -> Estimate:
    """Over a known number."""
    return Estimate(found.value / to, found.error / to)


def percent(share: float) -> str:
    """A relative difference, for print."""
    return f"{100.0 * share:+.2f}%"


def draw(Z: dict[float, Estimate]) -> Figure:
    """Z of the grains on top of what is known of it, and the differences."""
    figure = Figure(figsize=(8.5, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    n, measured = np.array(list(Z)), np.array([each.value for each in Z.values()])
    errors = np.array([each.error for each in Z.values()])
    fine = np.linspace(0.005, 0.76, 200)
    curves = {
        "virial series, Padé": (pade, "black", "-"),
        "Henderson": (theory.compressibility, "tab:blue", "--"),
        "Eq. (state)": (Grossman(0.0, 1.0, ALPHA).compressibility, "tab:red", "-."),
    }
    for label, (law, color, dash) in curves.items():
        left.plot(fine, law(fine), dash, color=color, linewidth=1.0, label=label)
        right.plot(fine, 100.0 * (law(fine) / pade(fine) - 1.0), dash, color=color, linewidth=1.0)
    look = {"fmt": "o", "color": "black", "ms": 4, "mfc": "white", "label": "grains"}
    left.errorbar(n, measured, errors, **look)
    right.errorbar(n, 100.0 * (measured / pade(n) - 1.0), 100.0 * errors / measured, **look)
    left.set_ylabel("$p/(nT)$")
    right.set_ylabel("difference from the series, %")
    for axis, title in ((left, "(a)"), (right, "(b)")):
        axis.set_xlabel("$n/n_c$")
        axis.set_title(title, fontsize=10)
    left.legend(fontsize=8)
    return figure
