"""The implicit integrator: iterations, milliseconds per part, its linear solver beside others, Fig. 4.

    python benchmarks/implicit.py            # all parts, some minutes
    python benchmarks/implicit.py PART ...   # iterations, parts, linear, viscous, fig4

Prints the section "The implicit integrator" of docs/performance.md. pyamg is compared with where it is installed.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import math
import time
from collections.abc import Callable, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from measure import processor
from scipy import sparse
from scipy.sparse.linalg import splu

from hydro.cli import main as hydro
from hydro.deck import EvolutionDeck, load
from hydro.driver.march import Run, advance
from hydro.dynamics import LagrangeRemap, multigrid
from hydro.dynamics.lagrange import integrator as lagrange
from hydro.dynamics.lagrange.integrator import SOLVED
from hydro.dynamics.multigrid import stencil
from hydro.dynamics.multigrid.level import Level
from hydro.initial import initial_state
from hydro.initial.cosine import cosine_averages
from hydro.markdown import table
from hydro.mesh import Mesh
from hydro.setup import gas_of, integrator_of, wall_of
from hydro.state import State
from hydro.steady.localized import steady_state
from hydro.terms.viscosity.implicit import SHARE
from hydro.walls import boundary

ROOT = Path(__file__).parents[1]
DECK = ROOT / "problems" / "fig4.toml"
EXPLICIT, IMPLICIT = "godunov", "lagrange-remap"
GRIDS = (32, 64, 128, 256, 512)
STEPS_OF_TIME = (0.01, 0.1, 1.0, 10.0)
PUSH = 0.01  # relative amplitude of the cosine in y that sets the cluster in motion
SETTLING, COUNTED = 30, 10  # steps
WITHOUT_LIMIT = 1e9
pyamg: Any = importlib.import_module("pyamg") if importlib.util.find_spec("pyamg") else None
REACHED = 1e-9  # residual of the linear solves, relative
CLUSTERS = {"clusters of Fig. 4": (0.0235, 2), "dense cluster": (0.04, 1)}  # f and half-waves
FIG4 = "clusters of Fig. 4"
ROUNDS = 5
VISCOUS_GRIDS = (32, 64, 128)


def deck_of(nx: int) -> EvolutionDeck:
    """Fig. 4 on nx x 2 nx cells."""
    deck = load(DECK, [f"mesh.cells=[{nx},{2 * nx}]"])
    assert isinstance(deck, EvolutionDeck)
    return deck


@cache
def cluster(nx: int, name: str) -> State:
    """A steady state in the box of Fig. 4."""
    deck, (f, wave) = deck_of(nx), CLUSTERS[name]
    mesh = Mesh.rectangle((nx, 2 * nx), deck.box.aspect_ratio)
    return steady_state(gas_of(deck), wall_of(deck), mesh, f, wave).state


def moving(nx: int, name: str) -> State:
    """A cluster state with its temperature changed by a cosine."""
    state = cluster(nx, name)
    factor = 1.0 + PUSH * cosine_averages(state.mesh, 3)
    return State.of(state.gas, state.mesh, state.density, state.temperature * factor, state.velocity)


def run_of(nx: int, state: State, dt: float = math.inf) -> Run:
    """A run from `state`, with steps up to `dt`; given that, the error does not limit them."""
    deck = deck_of(nx)
    integrator = integrator_of(deck, state)
    assert isinstance(integrator, LagrangeRemap)
    integrator.tolerance = WITHOUT_LIMIT if dt < math.inf else integrator.tolerance
    return Run(state, integrator, math.inf, dt)


def per_step(run: Run, settling: int, counted: int) -> tuple[float, float]:
    """Iterations per step, and the mean step, of the steps after `settling`."""
    for _ in range(settling):
        advance(run, math.inf)
    integrator: Any = run.integrator
    before, start = integrator.iterations, run.state.time
    for _ in range(counted):
        advance(run, math.inf)
    return (integrator.iterations - before) / counted, (run.state.time - start) / counted


def iterations() -> str:
    """Iterations per step against grid, step and density."""
    rows = []
    for name in CLUSTERS:
        for dt in STEPS_OF_TIME:
            row = []
            for nx in GRIDS:
                count, mean = per_step(run_of(nx, moving(nx, name), dt), SETTLING, COUNTED)
                row.append(f"{count:.1f}" + (f" ({mean:.2g})" if mean < 0.9 * dt else ""))
            rows.append([name, f"{dt:g}", *row])
    row = []
    for nx in GRIDS:
        deck = deck_of(nx)
        count, mean = per_step(run_of(nx, initial_state(deck)), 0, 100)
        row.append(f"{count:.1f} ({mean:.2g})")
    rows.append(["start of Fig. 4, first 100 steps", "chosen", *row])
    densities = "; ".join(
        f"{name}: f = {f:g}, half-waves: {wave}, n from {cluster(GRIDS[-1], name).density.min():.2g} to "
        f"{cluster(GRIDS[-1], name).density.max():.5f}"
        for name, (f, wave) in CLUSTERS.items()
    )
    return f"""### Iterations per step

One iteration is an exact residual and one multigrid cycle; a step ends when the error of pressure and temperature is
below
{SHARE:g} of what the first guess missed, or below {SOLVED:g}. Steady states at L = 5e4, aspect
ratio 2, their temperature changed by a cosine of {PUSH:.0%}: mean of {COUNTED} steps after {SETTLING}, the step given
by hand, not by the error; in brackets the mean step where the remap's limit made it shorter, or where the error chose
it. On the finest grid:
{densities}.

{table(["state", "dt", *(f"{nx} x {2 * nx}" for nx in GRIDS)], rows)}"""


class Clock:
    """Adds up the time that functions take, by name, where they are looked up."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self.calls: dict[str, int] = {}
        self._undo: list[Callable[[], None]] = []

    def watch(self, owner: Any, name: str, label: str) -> None:
        """Time `owner.name` under `label`, until `stop`."""
        inner = getattr(owner, name)

        def timed(*arguments: Any) -> Any:
            start = time.perf_counter()
            result = inner(*arguments)
            self.seconds[label] = self.seconds.get(label, 0.0) + time.perf_counter() - start
            self.calls[label] = self.calls.get(label, 0) + 1
            return result

        setattr(owner, name, timed)
        self._undo.append(lambda: setattr(owner, name, inner))

    def stop(self) -> None:
        for undo in self._undo:
            undo()


PARTS = (
    (lagrange, "look_ahead", "extrapolation"),
    (lagrange, "carry", "swept profiles"),
    (lagrange, "find_closures", "closures"),
    (boundary.Boundary, "give_heat", "heat of walls"),
    (lagrange, "balance", "residuals"),
    (lagrange, "find_jacobian", "derivatives"),
    (multigrid.Hierarchy, "prepare", "coarse levels and stencils"),
    (multigrid.Hierarchy, "cycle", "multigrid cycles"),
    (lagrange, "correct", "corrections"),
    (lagrange, "complete", "new state"),
    (lagrange, "unforeseen_change", "error"),
    (lagrange, "sweep_rate", "limit of the step"),
)


def parts(nx: int = 128, steps: int = 100) -> str:
    """Milliseconds per step and per part, along the start of Fig. 4."""
    run = run_of(nx, initial_state(deck_of(nx)))
    for _ in range(20):
        advance(run, math.inf)
    clock = Clock()
    for owner, name, label in PARTS:
        clock.watch(owner, name, label)
    integrator: Any = run.integrator
    before, start = integrator.iterations, time.perf_counter()
    for _ in range(steps):
        advance(run, math.inf)
    total = time.perf_counter() - start
    clock.stop()
    rows = [
        [label, f"{clock.calls[label] / steps:.1f}", f"{1e3 * seconds / steps:.2f}", f"{seconds / total:.0%}"]
        for label, seconds in clock.seconds.items()
    ]
    rest = total - sum(clock.seconds.values())
    rows += [["the rest", "", f"{1e3 * rest / steps:.2f}", f"{rest / total:.0%}"]]
    rows += [["whole step", "", f"{1e3 * total / steps:.2f}", "100%"]]
    count = (integrator.iterations - before) / steps
    return f"""### Milliseconds per step

Fig. 4 on {nx} x {2 * nx} cells, {steps} steps after the first 20, {count:.1f} iterations per step, one thread.

{table(["part", "calls per step", "ms per step", "share"], rows)}"""


def assembled(level: Level) -> sparse.csc_matrix:
    """The matrix of a level: unknowns are pressures, then temperatures, of the cells in order."""
    s, (nx, ny) = level.equations.stencil.astype(float).swapaxes(0, 1), level.shape
    mass_x, mass_y = (
        faces[:, multigrid.MASS].astype(float) for faces in (level.equations.faces_x, level.equations.faces_y)
    )
    here = np.arange(nx * ny).reshape(nx, ny)
    m = stencil
    below_x, above_x, below_y, above_y = (np.roll(here, k, a) for a in (0, 1) for k in (1, -1))
    cells = nx * ny
    entries = [
        (0, 0, here, s[m.D11]), (0, 1, here, s[m.D12]), (1, 0, here, s[m.D21]), (1, 1, here, s[m.D22]),
        (0, 0, below_x, -mass_x), (0, 0, above_x, -np.roll(mass_x, -1, 0)),
        (0, 0, below_y, -mass_y), (0, 0, above_y, -np.roll(mass_y, -1, 1)),
        (1, 0, below_x, s[m.XL_P]), (1, 1, below_x, s[m.XL_T]), (1, 0, above_x, s[m.XH_P]), (1, 1, above_x, s[m.XH_T]),
        (1, 0, below_y, s[m.YL_P]), (1, 1, below_y, s[m.YL_T]), (1, 0, above_y, s[m.YH_P]), (1, 1, above_y, s[m.YH_T]),
    ]  # fmt: skip
    rows = np.concatenate([(row * cells + here).ravel() for row, _, _, _ in entries])
    columns = np.concatenate([(column * cells + there).ravel() for _, column, there, _ in entries])
    values = np.concatenate([value.ravel() for _, _, _, value in entries])
    kept = values != 0.0
    return sparse.csc_matrix((values[kept], (rows[kept], columns[kept])), shape=(2 * cells, 2 * cells))


def by_cycles(hierarchy: multigrid.Hierarchy, matrix: sparse.csr_matrix, right: np.ndarray) -> tuple[np.ndarray, int]:
    """Solution by cycles under residuals in double precision, and their number."""
    finest, goal = hierarchy.levels[0], REACHED**2 * np.sum(right**2)
    solution, residual, count = np.zeros_like(right), right, 0
    while np.sum(residual**2) > goal and count < 100:
        finest.right[:] = residual.reshape(2, *finest.shape).swapaxes(0, 1)
        hierarchy.cycle()
        solution = solution + finest.unknowns[:, :, 1:-1].swapaxes(0, 1).reshape(-1)
        residual = right - matrix @ solution
        count += 1
    return solution, count


def median_ms(action: Callable[[], Any]) -> float:
    """Median of some rounds."""
    taken = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        action()
        taken.append(time.perf_counter() - start)
    return 1e3 * float(np.median(taken))


def by_pyamg(matrix: sparse.csr_matrix, right: np.ndarray) -> tuple[str, str, str]:
    """Milliseconds of set-up and of GMRES with Ruge-Stuben multigrid, its iterations and relative residual.

    The matrix is first multiplied by the inverses of its 2 x 2 blocks: of what pyamg offers, this did best.
    """
    cells = right.size // 2
    start = time.perf_counter()
    d11, d22 = matrix.diagonal().reshape(2, cells)
    d12, d21 = matrix.diagonal(cells), matrix.diagonal(-cells)
    over = 1.0 / (d11 * d22 - d12 * d21)
    inverse = sparse.bmat(
        [
            [sparse.diags(d22 * over), sparse.diags(-d12 * over)],
            [sparse.diags(-d21 * over), sparse.diags(d11 * over)],
        ]
    ).tocsr()
    pairs = np.arange(right.size).reshape(2, -1).T.ravel()  # pressure and temperature of a cell side by side
    hierarchy = pyamg.ruge_stuben_solver((inverse @ matrix)[pairs][:, pairs].tocsr())
    middle = time.perf_counter()
    residuals: list[float] = []
    found = hierarchy.solve((inverse @ right)[pairs], tol=REACHED, maxiter=100, accel="gmres", residuals=residuals)
    end = time.perf_counter()
    solution = np.empty_like(found)
    solution[pairs] = found
    reached = np.linalg.norm(right - matrix @ solution) / np.linalg.norm(right)
    return f"{1e3 * (middle - start):.0f}", f"{1e3 * (end - middle):.0f}", f"{len(residuals) - 1} ({reached:.0e})"


def linear() -> str:
    """One linear solve by cycles, by a sparse factorization, and by algebraic multigrid."""
    rows = []
    for nx in (64, 128):
        for dt in (0.1, 1.0):
            run = run_of(nx, moving(nx, FIG4), dt)
            _, mean = per_step(run, SETTLING, 1)
            hierarchy: multigrid.Hierarchy = getattr(run.integrator, "_hierarchy")  # noqa: B009
            matrix = assembled(hierarchy.levels[0])
            by_rows, right = matrix.tocsr(), np.random.default_rng(1).standard_normal(matrix.shape[0])
            solution, count = by_cycles(hierarchy, by_rows, right)
            exact = splu(matrix).solve(right)
            apart = np.linalg.norm(solution - exact) / np.linalg.norm(exact)
            prepare, cycle = median_ms(hierarchy.prepare), median_ms(hierarchy.cycle)
            whole = median_ms(partial(by_cycles, hierarchy, by_rows, right))
            factor = median_ms(partial(splu, matrix))
            factors = splu(matrix)
            solve = median_ms(partial(factors.solve, right))
            algebraic = by_pyamg(by_rows, right) if pyamg else ("not installed", "", "")
            rows.append(
                [f"{nx} x {2 * nx}", f"{mean:.2g}", f"{prepare:.1f}", f"{cycle:.2f}", count, f"{prepare + whole:.0f}",
                 f"{factor:.0f}", f"{solve:.1f}", f"{(factor + solve) / (prepare + whole):.0f}", f"{apart:.0e}",
                 *algebraic]
            )  # fmt: skip
    header = ["grid", "dt", "set-up, ms", "cycle, ms", f"cycles to {REACHED:g}", "multigrid in all, ms"]
    header += [
        "splu, ms",
        "its solve, ms",
        "ratio",
        "difference",
        "pyamg's set-up, ms",
        "its solve, ms",
        "iterations (residual)",
    ]
    return f"""### One linear solve beside scipy's splu and pyamg

The matrix of one step of the perturbed cluster of Fig. 4, assembled from the finest level's stencil; random right-hand
side, medians of {ROUNDS}. pyamg: GMRES with Ruge-Stuben multigrid of the matrix times the inverses of its 2 x 2 blocks,
which did best of what it offers, to the same residual. A step of the integrator needs no solution to {REACHED:g}: one
cycle per Newton iteration is enough.

{table(header, rows)}"""


def summary(integrator: str, nx: int) -> dict[str, Any]:
    """The summary of Fig. 4 with the round values of docs/fig4.md; papers/fig4.py shares the folders of these runs."""
    folder = ROOT / "output" / "fig4_grids" / f"{integrator}_{nx}"
    if not (folder / "summary.json").exists():
        words = [f"time.integrator={integrator}", f"mesh.cells=[{nx},{2 * nx}]"]
        words += ["gas.K=2e-3", "gas.tau=200", "initial.temperature=1"]
        if hydro([str(DECK), *words, "--output", str(folder), "--quiet", "--overwrite"]):
            raise SystemExit(f"{folder.name} failed")
    return json.loads((folder / "summary.json").read_text())


def fig4(nx: int = 64) -> str:
    """Fig. 4 by both integrators."""
    results = {name: summary(name, nx) for name in (EXPLICIT, IMPLICIT)}
    rows = [[f"`{name}`", result["steps"], f"{result['wall_seconds']:.1f}"] for name, result in results.items()]
    ratio = results[EXPLICIT]["wall_seconds"] / results[IMPLICIT]["wall_seconds"]
    return f"""### Fig. 4 by both integrators

`problems/fig4.toml` to t = 1290 on {nx} x {2 * nx} cells, compilation left out; ratio {ratio:.0f}. The errors are
similar, see [fig4.md](fig4.md), where these runs come from; it also has other grids.

{table(["integrator", "steps", "seconds"], rows)}"""


def viscous(until: float = 100.0) -> str:
    """What viscosity costs, along Fig. 4."""
    rows = []
    for nx in VISCOUS_GRIDS:
        row: list[Any] = [f"{nx} x {2 * nx}"]
        for viscosity in (0, 1):
            deck = load(DECK, [f"mesh.cells=[{nx},{2 * nx}]", f"gas.viscosity={viscosity}", "gas.tau=inf"])
            assert isinstance(deck, EvolutionDeck)
            state = initial_state(deck)
            run = Run(state, integrator_of(deck, state), until)
            advance(run, until)
            start = time.perf_counter()
            run.march([])
            row += [run.steps, f"{1e3 * (time.perf_counter() - start) / run.steps:.1f}"]
        integrator: Any = run.integrator
        iterations = sum(stress.iterations for stress in integrator.stresses)
        rows.append([*row, f"{iterations / run.steps:.0f}"])
    header = ["grid", "steps without viscosity", "ms per step", "steps with viscosity", "ms per step"]
    return f"""### Viscosity

Fig. 4 to t = {until:g} with viscosity instead of friction.

{table([*header, "its iterations per step"], rows)}"""


ALL: dict[str, Callable[[], str]] = {
    "iterations": iterations, "parts": parts, "linear": linear, "viscous": viscous, "fig4": fig4
}  # fmt: skip


def report(parts: Sequence[str]) -> None:
    """Print the section."""
    print("## The implicit integrator\n")
    print(f"Printed by `python benchmarks/implicit.py`. Processor: {processor()}.")
    for name in parts:
        print("\n" + ALL[name](), flush=True)


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"of {', '.join(ALL)}; all by default")
    wanted = parser.parse_args().parts or list(ALL)
    if unknown := set(wanted) - set(ALL):
        parser.error(f"no such part: {', '.join(unknown)}")
    report(wanted)


if __name__ == "__main__":
    main()
