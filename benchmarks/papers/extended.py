"""Figures and tables of docs/steady1d.md: `python benchmarks/papers/extended.py [--tables]`.

Writes docs/fig1, fig2, limits, localized and large_L as .png and .pdf (about two minutes). With --tables it prints, in
place of that, the measurements of the verification book that the page quotes, in their full version.
"""

from __future__ import annotations

import argparse
import math
import shutil
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.special import expit

from hydro.cli import main as hydro
from hydro.gas import Grossman
from hydro.pictures.marginal import power
from hydro.pictures.style import publish
from hydro.steady.extended import extended_state
from hydro.steady.grossman_limits import (
    dense_log_void,
    dense_start,
    dilute_aspect_ratio,
    dilute_end,
    dilute_mass,
    dilute_profile,
    growth_of_least_fraction,
)
from hydro.steady.marginal import critical_aspect_ratio, principal_mode, tongue, vanishing_tongue
from hydro.verification import MEASUREMENTS
from hydro.verification.book import section

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
WALLS = {"vibrating": "-", "thermal": ":"}
VANISHING = {"vibrating": (1e2, 1e3), "thermal": (1e3, 1e4)}
LEVELS = (0.01, 0.1)  # relative errors up to which a limit is drawn to hold
CONSTANT = 0.5318025  # of f_min L^(1/2) in an endless box, from the verification book


def gas(L: float) -> Grossman:
    """The paper's gas; K makes no difference."""
    return Grossman(L, 1.0)


def main() -> None:
    """Draw, or print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tables", action="store_true", help="print tables instead of drawing")
    if parser.parse_args().tables:
        for measurement in MEASUREMENTS:
            if measurement.function.__module__.endswith((".extended", ".marginal")):
                print("\n".join(section(measurement, measurement.findings(full=True))), flush=True)
        return
    for name in ("fig1", "fig2"):
        from_deck(name)
    for name, draw in (("limits", limits), ("localized", localized), ("large_L", large_losses)):
        publish(draw(), DOCS / name)
        print(f"docs/{name}.png", flush=True)


def from_deck(name: str) -> None:
    """The picture of a deck of problems/."""
    with tempfile.TemporaryDirectory() as scratch:
        hydro([str(ROOT / "problems" / f"{name}.toml"), "--output", f"{scratch}/{name}"])
        for suffix in (".png", ".pdf"):
            shutil.copyfile(f"{scratch}/{name}/pictures/marginal{suffix}", DOCS / f"{name}{suffix}")


def limits() -> Figure:
    """Profiles beside their limits, where the limits hold, and Eq. (asymp)."""
    figure = Figure(figsize=(10.5, 3.4), layout="constrained")
    axes = figure.subplots(1, 3)
    profiles(axes[0])
    regions(axes[1])
    dilute_formula(axes[2])
    return figure


def profiles(axis: Axes) -> None:
    """A dense cluster with u = u(0) cosh(kx), and a dilute box, at L = 5e4."""
    x = np.linspace(0.0, 1.0, 801)
    cluster, box = extended_state(gas(5e4), 0.2), extended_state(gas(5e4), 3e-3)
    axis.semilogy(x, cluster.density_at(x), color="black", label="$f=0.2$")
    dense = expit(-dense_log_void(gas(5e4), cluster.w0, x))
    axis.semilogy(x, dense, "--", color="tab:red", label=r"$u=u_0\cosh kx$")
    axis.semilogy(x, box.density_at(x), color="0.5", label="$f=0.003$")
    axis.semilogy(*dilute_profile(gas(5e4), 3e-3), "--", color="tab:blue", label=r"$z=z_0\cosh^2\theta$")
    axis.set_ylim(1e-3, 1.5)
    axis.set_xlim(0.0, 1.0)
    axis.set_xlabel("$x$")
    axis.set_ylabel("$n/n_c$")
    axis.set_title(r"(a)  profiles, $\mathcal{L}=5\cdot 10^4$", fontsize=10)
    axis.legend(fontsize=8)


def regions(axis: Axes) -> None:
    """Where the limits give n, or 1-n, at both walls of the box to 1% and 10%."""
    u = np.linspace(math.log(1e-5), -math.log(1e-5), 61)  # log(f/(1-f))
    losses = np.geomspace(1e2, 1e8, 31)
    dilute, dense, formula = (np.full((len(losses), len(u)), np.inf) for _ in range(3))
    for i, L in enumerate(losses.tolist()):
        for j, f in enumerate((1.0 / (1.0 + np.exp(-u))).tolist()):
            state = extended_state(gas(L), f)
            w = state.log_void_at(np.array([0.0, 1.0]))
            start = dense_start(gas(L), f)
            dense[i, j] = np.abs(
                np.expm1(np.clip(dense_log_void(gas(L), start, np.array([0.0, 1.0])) - w, -50, 50))
            ).max()
            if f < 0.3 and dilute_mass(gas(L), f) < 20.0:
                n = dilute_profile(gas(L), f)[1]
                dilute[i, j] = np.abs(n[[0, -1]] / state.wall_density - 1.0).max()
            exact, approximate = critical_aspect_ratio(state, "vibrating").aspect_ratio, dilute_aspect_ratio(gas(L), f)
            if f < 0.3 and exact and approximate:
                formula[i, j] = abs(approximate / exact - 1.0)
        formula[i] = beyond_best(formula[i])
    for values, color, label in (
        (dilute, "tab:blue", "dilute $n$"), (dense, "tab:red", "dense $1-n$"), (formula, "tab:green", "Eq. (asymp)"),
    ):  # fmt: skip
        for level, alpha in zip(LEVELS, (0.55, 0.25), strict=True):
            inside = np.where(np.isfinite(values), np.log10(np.maximum(values, 1e-12)), 2.0)
            axis.contourf(u, losses, inside, levels=[-20.0, math.log10(level)], colors=[color], alpha=alpha)
        axis.plot([], [], "s", color=color, label=label)
    axis.set_yscale("log")
    ticks = (1e-4, 1e-2, 0.5, 1.0 - 1e-2, 1.0 - 1e-4)
    axis.set_xticks([math.log(f / (1.0 - f)) for f in ticks], ["$10^{-4}$", "0.01", "0.5", "0.99", "$1-10^{-4}$"])
    axis.set_xlabel("area fraction $f$")
    axis.set_ylabel(r"$\mathcal{L}$")
    axis.set_title("(b)  limits good to 1% (dark), 10% (light)", fontsize=10)
    axis.legend(fontsize=8, loc="upper center")


def beyond_best(errors: np.ndarray) -> np.ndarray:
    """Errors that no longer fall behind their first minimum: two curves that cross by chance do not agree."""
    first = int(np.argmax(errors < LEVELS[-1]))
    while first + 1 < len(errors) and errors[first + 1] < errors[first]:
        first += 1
    return np.concatenate([errors[:first], np.maximum.accumulate(errors[first:])])


def dilute_formula(axis: Axes) -> None:
    """Eq. (asymp) beside Delta_1, vibrating wall."""
    for L, color in ((1e3, "tab:purple"), (5e4, "black"), (1e6, "tab:orange")):
        end = dilute_end(gas(L))
        f = end * np.geomspace(1.01, 0.15 / end, 160)
        exact = [critical_aspect_ratio(extended_state(gas(L), each), "vibrating").aspect_ratio for each in f.tolist()]
        formula = [dilute_aspect_ratio(gas(L), each) for each in f.tolist()]
        scaled = [[each * math.sqrt(L) if each else math.nan for each in values] for values in (exact, formula)]
        axis.loglog(f, scaled[0], color=color, label=rf"$\mathcal{{L}}={power(L)}$")
        axis.loglog(f, scaled[1], "--", color=color, linewidth=0.9)
    axis.set_ylim(80.0, 1e9)
    axis.set_xlabel("area fraction $f$")
    axis.set_ylabel(r"$\Delta_1\,\mathcal{L}^{1/2}$")
    axis.set_title(r"(c)  $\Delta_1$, and Eq. (asymp) dashed", fontsize=10)
    axis.legend(fontsize=8)


def localized() -> Figure:
    """Eigenfunctions before both walls, and how far their critical aspect ratios differ."""
    figure = Figure(figsize=(8.5, 3.5), layout="constrained")
    left, right = figure.subplots(1, 2)
    least = tongue(gas(5e4), "vibrating").f_min or math.nan
    for share, color in ((0.5, "tab:blue"), (1.0, "black"), (1.4, "tab:red")):
        state = extended_state(gas(5e4), share * least)
        for wall, dash in WALLS.items():
            mode = principal_mode(state, wall)
            label = f"$f={share * least:.4f}$" if wall == "vibrating" else None
            left.plot(mode.x, mode.phi, linestyle=dash, color=color, label=label)
    left.set_xlim(0.0, 1.0)
    left.set_ylim(0.0, 1.05)
    left.set_xlabel("$x$")
    left.set_ylabel(r"eigenfunction $\varphi$, peak 1")
    left.set_title(r"(a)  $\mathcal{L}=5\cdot 10^4$; dotted: thermal wall", fontsize=10)
    left.legend(fontsize=8)
    for L, color in ((5e3, "tab:purple"), (5e4, "black"), (2e5, "tab:green"), (1e6, "tab:orange")):
        found = tongue(gas(L), "thermal")
        f = np.linspace(found.f1 or 0.0, found.f2 or 0.0, 82)[1:-1]
        states = [extended_state(gas(L), each) for each in f.tolist()]
        ratios = [[critical_aspect_ratio(state, wall).aspect_ratio or math.nan for state in states] for wall in WALLS]
        apart = np.maximum(np.array(ratios[1]) / np.array(ratios[0]) - 1.0, 1e-16)
        right.semilogy(f * math.sqrt(L), apart, color=color, label=rf"$\mathcal{{L}}={power(L)}$")
    right.set_ylim(1e-13, 10.0)
    right.set_xlabel(r"$f\,\mathcal{L}^{1/2}$")
    right.set_ylabel(r"$\Delta_1^{\mathrm{thermal}}/\Delta_1^{\mathrm{vibrating}}-1$")
    right.set_title("(b)  the two walls' curves", fontsize=10)
    right.legend(fontsize=8)
    return figure


def large_losses() -> Figure:
    """Tongues against L: their least Delta_1, their ends, and the growth of f_min L^(1/2)."""
    figure = Figure(figsize=(10.5, 3.4), layout="constrained")
    least, ends, growth = figure.subplots(1, 3)
    for (wall, dash), color in zip(WALLS.items(), ("black", "tab:red"), strict=True):
        start, _ = vanishing_tongue(gas(1.0), "L", wall, *VANISHING[wall])
        losses = start * np.concatenate([1.0 + np.geomspace(1e-3, 0.3, 8), np.geomspace(1.4, 1e8 / start, 40)])
        found = [tongue(gas(L), wall) for L in losses.tolist()]
        columns = {name: np.array([getattr(each, name) for each in found]) for name in vars(found[0])}
        look = {"linestyle": dash, "color": color}
        least.loglog(losses, columns["aspect_ratio_min"] * np.sqrt(losses), **look, label=f"{wall} wall")
        least.axvline(start, color=color, linewidth=0.5)
        least.text(start * 1.1, 1.2e3, rf"$\mathcal{{L}}={start:.1f}$", rotation=90, fontsize=8, va="center")
        ends.fill_between(losses, columns["f1"], columns["f2"], color=color, alpha=0.12, linewidth=0)
        ends.loglog(losses, columns["f1"], **look, label=f"$f_1$, $f_2$: {wall} wall")
        ends.loglog(losses, columns["f2"], **look)
        growth.semilogx(losses, columns["f_min"] * np.sqrt(losses), **look, label=f"{wall} wall")
    losses = np.geomspace(1e2, 1e8, 50)
    ends.loglog(losses, [dilute_end(gas(L)) for L in losses], "--", color="0.5", label=r"$3\alpha^2(1+a)/\mathcal{L}$")
    line = growth_of_least_fraction(gas(1.0)) * np.log(losses) + CONSTANT
    growth.semilogx(losses, line, "--", color="0.5", label=r"$(\alpha/8^{1/2})\,\ln\mathcal{L}+0.5318$")
    least.set_ylim(100.0, 2e3)
    least.set_yticks([100, 144.83, 200, 500, 1000, 2000], ["100", "144.83", "200", "500", "1000", "2000"])
    least.set_ylabel(r"$\Delta_1^{\mathrm{(min)}}\,\mathcal{L}^{1/2}$")
    ends.set_ylabel("area fraction $f$")
    growth.set_ylabel(r"$f_{\mathrm{min}}\,\mathcal{L}^{1/2}$")
    titles = ("(a)  least critical aspect ratio", "(b)  tongues", "(c)  area fraction of the least")
    for title, axis in zip(titles, (least, ends, growth), strict=True):
        axis.set_xlabel(r"$\mathcal{L}$")
        axis.set_title(title, fontsize=10)
        axis.legend(fontsize=8)
    return figure


if __name__ == "__main__":
    main()
