"""What the eight numbers of Fig. 4 say of K, tau, T(0) and W, which the paper does not give.

    python benchmarks/papers/calibrate.py [--cells 48] > docs/calibration.md

Least squares of the logarithms of the ratios of `problems/fig4.toml` to the paper's numbers, in the logarithms of the
parameters; derivatives by central differences. The sum of squares has several minima, so a scan on a coarse grid says
where to start. Some four hundred runs, a second or a few each.
"""

from __future__ import annotations

import argparse
import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from evolve import evolve
from fig4 import DECK, NAMES, PAPER
from scipy.optimize import OptimizeResult, least_squares

from hydro.markdown import table
from hydro.observables.clustering import wall_extremes

KEYS = {"K": "gas.K", "tau": "gas.tau", "T(0)": "initial.temperature", "W": "wall.W"}
GIVEN = {"K": 2e-3, "tau": 200.0, "T(0)": 1.0, "W": 114.0}
SCAN = {
    "K": (0.5e-3, 0.8e-3, 1.2e-3, 2e-3, 3e-3, 5e-3),
    "tau": (30.0, 60.0, 120.0, 200.0, 400.0, 800.0, 1600.0, 5000.0),
    "T(0)": (0.5, 1.0, 2.0),
}
SCAN_CELLS = 32
BOUNDS = {"K": (2e-4, 2e-2), "tau": (10.0, 2e4), "T(0)": (0.2, 5.0)}  # of the fits
STARTS = 4  # fits, from the best of the scan's minima
STEP = 0.04  # of the logarithm of a parameter, for derivatives
LAST_DIGIT = (0.005, 0.005, 0.005, 0.005, 0.005, 0.0005, 0.0005, 0.0005)  # half a unit of it, in the paper's numbers

HEAD = """# Calibration of Fig. 4

Printed by `python benchmarks/papers/calibrate.py --cells {cells}`: `problems/fig4.toml` on {cells} x {double} cells,
fitted to the eight wall densities that the paper gives, by least squares of log(calculated/paper). The paper gives
neither K nor tau, W or the initial temperature T(0). W = 114 is kept: it sets the unit of temperature, with T close to
1 at the wall.
"""
SCANNED = """## Where the minima are

Rms of the eight log ratios on {cells} x {double} cells."""
MEANING = """
Standard errors come from the Jacobian and from the residuals themselves, s^2 = sum r^2/(8 - number of parameters). The
residuals are not random (below), so they are a scale rather than a confidence."""
SENSITIVE = """
## What the numbers depend on

Logarithmic derivatives of the eight numbers at the best fit of three: relative change of the number per relative
change of the parameter.
"""
SINGULAR = """
Singular values of this matrix, and the combinations they belong to. The combination x of logarithms is known with the
error s/(singular value), s = {scatter:.3f} from the residuals above.
"""


class Model:
    """The eight numbers as functions of parameters, with a memory of what has been calculated."""

    def __init__(self, cells: int):
        self._cells, self._known = cells, dict[tuple[float, ...], np.ndarray]()

    @property
    def runs(self) -> int:
        return len(self._known)

    def log_ratios(self, parameters: dict[str, float]) -> np.ndarray:
        """log(calculated/paper), maxima first."""
        full = GIVEN | parameters
        key = tuple(full.values())
        if key not in self._known:
            found: list[tuple[float, float]] = []
            words = [f"mesh.cells=[{self._cells},{2 * self._cells}]"]
            words += [f"{KEYS[name]}={value!r}" for name, value in full.items()]
            evolve(DECK, words, lambda run: found.append(wall_extremes(run.state.density, run.state.mesh)))
            low, high = np.array(found).T
            self._known[key] = np.log([*high / PAPER["wall_max"], *low / PAPER["wall_min"]])
        return self._known[key]

    def slopes(self, parameters: dict[str, float], names: Sequence[str]) -> np.ndarray:
        """Derivatives of the log ratios in the logarithms of the named parameters, (8, names)."""
        columns = []
        for name in names:
            up, down = (parameters | {name: (GIVEN | parameters)[name] * math.exp(d)} for d in (STEP, -STEP))
            columns.append((self.log_ratios(up) - self.log_ratios(down)) / (2.0 * STEP))
        return np.transpose(columns)


class Fit(NamedTuple):
    """Fitted parameters, and what least squares says of them."""

    values: dict[str, float]
    found: OptimizeResult


def fit(model: Model, names: Sequence[str], first: dict[str, float]) -> Fit:
    """Least squares in the logarithms of the named parameters."""

    def named(logs: np.ndarray) -> dict[str, float]:
        return {name: math.exp(value) for name, value in zip(names, logs, strict=True)}

    found = least_squares(
        lambda logs: model.log_ratios(named(logs)), np.log([first[name] for name in names]),
        lambda logs: model.slopes(named(logs), names), bounds=np.log([BOUNDS[name] for name in names]).T,
        xtol=2e-3, ftol=2e-3, gtol=1e-4, max_nfev=15,
    )  # fmt: skip
    return Fit(named(found.x), found)


def scan(names: Sequence[str]) -> np.ndarray:
    """Rms of the log ratios at all combinations of the scan's values of the named parameters."""
    model = Model(SCAN_CELLS)
    points = itertools.product(*(SCAN[name] for name in names))
    values = [rms(model.log_ratios(dict(zip(names, point, strict=True)))) for point in points]
    return np.reshape(values, [len(SCAN[name]) for name in names])


def minima(names: Sequence[str], scanned: np.ndarray) -> list[dict[str, float]]:
    """The scan's local minima, best first, no more than STARTS."""
    padded = np.pad(scanned, 1, constant_values=np.inf)
    around = [
        padded[tuple(slice(1 + k, 1 + k + size) for k, size in zip(shift, scanned.shape, strict=True))]
        for shift in itertools.product((-1, 0, 1), repeat=scanned.ndim)
    ]
    places = np.argwhere(scanned <= np.min(around, axis=0))
    best = sorted(places.tolist(), key=lambda place: scanned[tuple(place)])[:STARTS]
    return [{name: SCAN[name][k] for name, k in zip(names, place, strict=True)} for place in best]


def fits(model: Model, names: Sequence[str], starts: Sequence[dict[str, float]]) -> Fit:
    """Fit from every start, print what each gives and what the best says; returns the best."""
    found = [fit(model, names, first) for first in starts]
    rows = [
        [", ".join(f"{first[name]:g}" for name in names), *(f"{one.values[name]:.4g}" for name in names),
         f"{rms(one.found.fun):.4f}"]
        for first, one in zip(starts, found, strict=True)
    ]  # fmt: skip
    print(table([f"start: {', '.join(names)}", *names, "rms"], rows) + "\n")
    best = min(found, key=lambda one: rms(one.found.fun))
    print("The best of them:\n\n" + report(names, best) + "\n", flush=True)
    return best


def rms(values: np.ndarray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def report(names: Sequence[str], fitted: Fit) -> str:
    """Values with their standard errors, correlations, and the rms of the residuals."""
    values, found = fitted
    scatter = np.sum(found.fun**2) / (found.fun.size - len(names))
    covariance = scatter * np.linalg.inv(found.jac.T @ found.jac)
    errors = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(errors, errors)
    rows = [
        [name, f"{values[name]:.4g}", f"{100 * errors[k]:.1f}%", *(f"{c:+.2f}" for c in correlation[k])]
        for k, name in enumerate(names)
    ]
    text = table(["parameter", "value", "standard error", *(f"correlation with {name}" for name in names)], rows)
    ends = [name for name, side in zip(names, found.active_mask, strict=True) if side]
    bounded = f" At the bound of the search: {', '.join(ends)}." if ends else ""
    return f"{text}\n\nRms of the eight log ratios: {rms(found.fun):.4f}.{bounded}"


def combination(names: Sequence[str], direction: np.ndarray) -> str:
    """A direction in the space of logarithms, as a sum; its largest part positive."""
    signed = direction * np.sign(direction[np.argmax(abs(direction))])
    return " ".join(f"{part:+.2f} log {name}" for name, part in zip(names, signed, strict=True))


def main() -> None:
    """Fit and print the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=int, default=48, help="across; twice as many along the wall")
    cells = parser.parse_args().cells
    model = Model(cells)
    print(HEAD.format(cells=cells, double=2 * cells))
    scanned = scan(("K", "tau", "T(0)"))
    print(SCANNED.format(cells=SCAN_CELLS, double=2 * SCAN_CELLS))
    for k, temperature in enumerate(SCAN["T(0)"]):
        rows = [[f"{K:g}", *(f"{x:.3f}" for x in line)] for K, line in zip(SCAN["K"], scanned[:, :, k], strict=True)]
        print(f"\nT(0) = {temperature:g}:\n\n" + table(["K, tau", *(f"{tau:g}" for tau in SCAN["tau"])], rows))

    print("\n## K and tau, with T(0) = 1\n")
    two = fits(model, ("K", "tau"), minima(("K", "tau"), scanned[:, :, SCAN["T(0)"].index(1.0)]))
    print("## K, tau and T(0)\n")
    names = ("K", "tau", "T(0)")
    three = fits(model, names, minima(names, scanned))
    print(MEANING, flush=True)

    finer = Model(2 * cells)
    columns = [model.log_ratios({}), two.found.fun, finer.log_ratios(two.values)]
    columns += [three.found.fun, finer.log_ratios(three.values)]
    rounding = np.log1p(np.array(LAST_DIGIT) / [*PAPER["wall_max"], *PAPER["wall_min"]])
    rows = [[name, f"{rounding[k]:.3f}", *(f"{column[k]:+.3f}" for column in columns)] for k, name in enumerate(NAMES)]
    rows.append(["rms", "", *(f"{rms(column):.3f}" for column in columns)])
    doubled = f"{2 * cells} x {4 * cells}"
    print("\n## Residuals\n\nlog(calculated/paper); beside it what half a unit of the last digit means for it.\n")
    header = ["number", "last digit", "K = 2e-3, tau = 200", "K, tau", f"K, tau, {doubled}"]
    print(table([*header, "K, tau, T(0)", f"K, tau, T(0), {doubled}"], rows), flush=True)

    all_names = list(KEYS)
    slopes = model.slopes(three.values, all_names)
    print(SENSITIVE)
    print(table(["number", *all_names], [[n, *(f"{s:+.3f}" for s in slopes[k])] for k, n in enumerate(NAMES)]))
    _, singular, directions = np.linalg.svd(slopes)
    scatter = float(np.sqrt(np.sum(three.found.fun**2) / (three.found.fun.size - 3)))
    print(SINGULAR.format(scatter=scatter))
    rows = [
        [f"{value:.3f}", f"{scatter / value:.2f}", combination(all_names, direction)]
        for value, direction in zip(singular, directions, strict=True)
    ]
    print(table(["singular value", "error of the combination", "combination"], rows))
    print(
        f"\n{scanned.size} runs on {SCAN_CELLS} x {2 * SCAN_CELLS} cells, {model.runs} on {cells} x {2 * cells}, "
        f"{finer.runs} on {doubled}."
    )


if __name__ == "__main__":
    main()
