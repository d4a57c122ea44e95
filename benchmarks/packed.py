"""Packed cores: does every plausible gas in a driven box run to its end, and with how many steps?

    python benchmarks/packed.py                       # all decks, by `lagrange-remap`
    python benchmarks/packed.py --integrator godunov  # much longer
    python benchmarks/packed.py --only 3              # the first three
    python benchmarks/packed.py --column              # what the equations do: a column at rest on three meshes

L = 5e4, K = 2e-3, W = 114, aspect ratio 2, 24 x 48 cells, to t = 300. Prints a table for docs/numerics.md.
"""

from __future__ import annotations

import argparse
import itertools
import math
from pathlib import Path
from typing import Any, NamedTuple

from hydro.deck import EvolutionDeck, load
from hydro.driver.march import Run, march
from hydro.errors import RunFailed
from hydro.initial import initial_state
from hydro.markdown import table
from hydro.setup import gas_of, integrator_of, wall_of
from hydro.steady.extended import extended_state

DECK = Path(__file__).parents[1] / "problems" / "fig4.toml"
END = 300.0
COMMON = ("gas.K=2e-3", "mesh.cells=[24,48]", f"time.end={END:g}", "initial.temperature=1.0", "output.times=[]")
MESHES, TIMES = (24, 48, 96), (5.0, 10.0, 20.0, 40.0, 100.0, 300.0)
VIBRATING, THERMAL = "vibrating", "thermal"


class Case(NamedTuple):
    """A gas and its start."""

    f: float
    amplitude: float
    tau: float
    viscosity: float = 0.0
    wall: str = VIBRATING
    start: str = "cosine"

    def deck(self, integrator: str) -> EvolutionDeck:
        """As a deck."""
        start = [f"initial.kind={self.start}", f"initial.amplitude={self.amplitude:g}"]
        wall = [f"wall.kind={self.wall}"]
        gas = [f"gas.f={self.f:g}", f"gas.tau={self.tau:g}", f"gas.viscosity={self.viscosity:g}"]
        found: Any = load(DECK, [*COMMON, *gas, *wall, *start, f"time.integrator={integrator}"])
        return found


def cases() -> list[Case]:
    """The first is the box of Fig. 4."""
    products, inf = itertools.product, math.inf
    return [
        Case(0.0235, 0.1, 200.0),
        Case(0.1, 0.9, 20.0),
        Case(0.1, 0.9, 200.0, 1.0),
        *(Case(*each) for each in products((0.03, 0.05, 0.1, 0.2, 0.3, 0.4), (0.1, 0.5, 0.9), (5.0, 200.0, inf))),
        *(Case(f, a, tau, 1.0) for f, a, tau in products((0.1, 0.3), (0.1, 0.9), (20.0, inf))),
        *(Case(f, a, tau, 0.0, THERMAL) for f, a, tau in products((0.1, 0.3), (0.1, 0.9), (20.0, inf))),
        *(Case(f, 0.01, 200.0, start="noise") for f in (0.05, 0.1, 0.2, 0.3)),
    ]  # fmt: skip


def outcome(case: Case, integrator: str) -> tuple[Any, ...]:
    """Steps, how many were rejected, the time reached, and the coldest cell at the end."""
    deck = case.deck(integrator)
    state = initial_state(deck)
    run = Run(state, integrator_of(deck, state), deck.time.end)
    try:
        run.march(())
        end = "reached the end"
    except RunFailed as failure:
        end = str(failure)
    speed = (state.speed / state.gas.sound_speed(state.density, state.temperature)).max()
    return run.steps, run.rejected, state.time, state.temperature.min(), 1 - state.density.max(), speed, end


def column() -> str:
    """The coldest cell of a column of f = 0.1, uniform at first, in time on three meshes; that of the steady state."""
    rows = []
    for nx in MESHES:
        deck: Any = load(DECK, [*COMMON, "gas.f=0.1", f"mesh.cells=[{nx},4]", "initial.kind=uniform"])
        state = initial_state(deck)
        integrator, coldest = integrator_of(deck, state), []
        for time in TIMES:
            march(state, integrator, time)
            coldest.append(f"{state.temperature.min():.4g}")
        rows.append((nx, *coldest))
    steady = extended_state(gas_of(deck), 0.1).temperature_at(0.0, wall_of(deck))
    printed = table(("cells", *(f"t = {time:g}" for time in TIMES)), rows)
    return f"{printed}\n\nColdest in the steady state: {float(steady):.4g}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--integrator", default="lagrange-remap")
    parser.add_argument("--only", type=int, help="number of decks")
    parser.add_argument("--column", action="store_true", help="a column at rest")
    options = parser.parse_args()
    if options.column:
        print(column())
        return
    heads = ("f", "amplitude", "tau", "viscosity", "wall", "start", "steps", "rejected", "t", "min T", "1 - max n")
    rows = []
    for case in cases()[: options.only]:
        row = (*case, *outcome(case, options.integrator))
        print(*row, flush=True)
        rows.append(row)
    print(table((*heads, "Mach", "end"), rows))
    most = max(row[6] for row in rows)
    print(f"\nSteps: {rows[0][6]} for the first, {most} at most: {most / rows[0][6]:.1f} times as many.")
    print(f"{sum(row[-1] != 'reached the end' for row in rows)} of {len(rows)} do not reach t = {END:g}.")


if __name__ == "__main__":
    main()
