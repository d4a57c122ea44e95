"""Does a gas that cools freely get through? `python benchmarks/free_cooling.py [COLLISIONS] [CELLS] [alone]`

Forty starts on 48 x 48 cells, periodic in both directions: four densities, r = 0.8 and 0.9, five seeds of a velocity
noise of 0.1; d/L_x = 0.005, viscosity 1, everything else by default. Each goes on until a grain has had 200 collisions
on average. A row for each start, with what fell back on the way; a last line says how many stopped before. With a third
word nothing falls back: the second-order update is alone.
"""

from __future__ import annotations

import itertools
import sys
import time
from typing import Any

from hydro.deck import parse
from hydro.driver.clock import collision_clock
from hydro.driver.march import Run, advance
from hydro.dynamics import Godunov
from hydro.errors import RunFailed
from hydro.initial import initial_state
from hydro.setup import integrator_of

DIAMETER, GAMMA = 0.005, 2.26
DECK = """
kind = "evolution"
gas = {{ L = {L}, f = {n}, K = {K}, viscosity = 1.0 }}
box = {{ periodic = ["x", "y"] }}
mesh = {{ cells = [{cells}, {cells}] }}
wall = {{ kind = "elastic" }}
initial = {{ kind = "noise", amplitude = 0.0, velocity = 0.1, seed = {seed} }}
time = {{ end = 1e12 }}
"""


def start(n: float, r: float, seed: int, cells: int) -> Run:
    """A run about to begin."""
    L = 32.0 / (3.0 * GAMMA) * (1.0 - r * r) / DIAMETER**2
    deck: Any = parse(DECK.format(L=L, n=n, K=DIAMETER, seed=seed, cells=cells))
    state = initial_state(deck)
    return Run(state, integrator_of(deck, state), deck.time.end, clock=collision_clock(deck))


def follow(run: Run, collisions: float) -> str:
    """Let a run go on to so many collisions per grain; why it stopped before, or nothing."""
    try:
        while run.reading["collisions_per_grain"] < collisions:
            advance(run, run.end)
    except RunFailed as error:
        return str(error)
    return ""


def main(collisions: float = 200.0, cells: int = 48, alone: str = "") -> int:
    """Print the table; how many runs stopped before."""
    if alone:
        Godunov._careful_flow = Godunov._flow  # type: ignore[method-assign]
    print("  n    r  seed  collisions     time   steps  rejected  first order  unstressed  mean T    min T    Mach  s")
    stopped = 0
    for r, n, seed in itertools.product((0.9, 0.8), (0.1, 0.2, 0.3, 0.4), range(5)):
        run, began = start(n, r, seed, cells), time.perf_counter()
        reason, state = follow(run, collisions), run.state
        stopped += bool(reason)
        counts, T = run.integrator.counts(), state.temperature
        print(
            f"{n:5.2f} {r:4.2f} {seed:4d} {run.reading['collisions_per_grain']:10.1f} {state.time:10.4g} {run.steps:6d}"
            f" {run.rejected:8d} {counts['first_order_cells']:10d} {counts['unstressed_cells']:10d}"
            f"  {T.mean():9.2e} {T.min():8.1e} {state.mach.max():6.1f} {time.perf_counter() - began:5.1f} {reason}",
            flush=True,
        )
    print(f"{stopped} of 40 stopped before {collisions:g} collisions per grain")
    return stopped


if __name__ == "__main__":
    sys.exit(main(*(kind(text) for kind, text in zip((float, int, str), sys.argv[1:], strict=False))) > 0)
