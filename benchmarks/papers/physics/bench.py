"""What all measurements share: keeping of results, errors, and boxes of grains."""

from __future__ import annotations

import hashlib
import json
import math
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hydro.gas import Grossman
from hydro.gas.grossman import LAMBDA, A
from hydro.grains.cells import arena
from hydro.grains.dynamics import COLUMNS, EPOCH, Dynamics
from hydro.grains.placement import CLOSE_PACKING, placed
from hydro.grains.walls import ElasticWall
from hydro.mesh import Mesh
from hydro.output.files import write_text
from hydro.state import State

FOLDER = Path(__file__).parents[3] / "output" / "grains_physics"
GAMMA, ALPHA = 2.26, 1.15  # of the paper's closures
DILUTE_CONDUCTIVITY = LAMBDA * ALPHA**2  # conductivity of the dilute gas over K T^(1/2)
PAPER = math.sqrt(2.0 / math.pi)  # of q = (2/pi)^(1/2) A^2 omega^2 n T^(1/2)


X, Y, VX, VY, TIME = (COLUMNS.index(name) for name in ("x", "y", "vx", "vy", "time"))


class Estimate(NamedTuple):
    """A mean and its standard error."""

    value: float
    error: float

    def __str__(self) -> str:
        digits = max(0, 1 - math.floor(math.log10(self.error))) if 0.0 < self.error < math.inf else 4
        return f"{self.value:.{digits}f} ± {self.error:.{digits}f}"


def estimate(values: Any) -> Estimate:
    """Of independent values, such as those of seeds or of blocks of time."""
    values = np.asarray(values, dtype=float)
    return Estimate(float(values.mean()), float(values.std(ddof=1) / math.sqrt(values.size)))


def kept(measure: Callable[..., dict[str, Any]], **parameters: Any) -> dict[str, Any]:
    """The result of a measurement, from the folder of results if it has been made before; JSON on the way."""
    name = measure.__name__
    asked = json.dumps(parameters, sort_keys=True)
    path = FOLDER / f"{name}-{hashlib.sha256(asked.encode()).hexdigest()[:12]}.json"
    if not path.exists():
        started = time.process_time()
        result = measure(**parameters)
        FOLDER.mkdir(parents=True, exist_ok=True)
        seconds = time.process_time() - started
        write_text(path, json.dumps({"parameters": parameters, "result": result, "seconds": seconds}))
        print(f"{name} {asked}: {seconds:.1f} s", file=sys.stderr, flush=True)
    return json.loads(path.read_text())["result"]


def diameter_of(number: int, n: float, length_y: float = 1.0) -> float:
    """d/L_x of so many grains of mean density n."""
    return math.sqrt(CLOSE_PACKING * n * length_y / number)


def mean_free_path(n, diameter):
    """Eq. (meanfree), in L_x."""
    return diameter * LAMBDA * (1.0 - n) / (n * (1.0 - A * n))


def box_of_grains(
    number: int, n: float, seed: int, wall: Any = None, restitution: float = 1.0, length_y: float = 1.0,
    periodic: tuple[bool, bool] = (True, True),
) -> Dynamics:  # fmt: skip
    """Grains of uniform density n and temperature 1."""
    diameter = diameter_of(number, n, length_y)
    state = State.of(Grossman(L=0.0, K=1.0), Mesh.rectangle((4, 4), length_y, periodic=periodic), n, 1.0)
    box = arena(diameter, restitution, length_y, periodic)
    return Dynamics(box, wall or ElasticWall(), *placed(state, number, diameter, seed), seed)


def redraw(grains: Dynamics, depth: float, random: np.random.Generator) -> None:
    """Give all grains at x < depth new velocities, those of a gas at rest of temperature 1: a reservoir of heat."""
    memory, positions = grains.memory(), grains.positions
    motion = memory["motion"]
    motion[:, X : Y + 1] = positions
    motion[:, TIME] = grains.time - memory["epoch"][0] * EPOCH
    inside = positions[:, 0] < depth
    motion[inside, VX : VY + 1] = random.standard_normal((int(inside.sum()), 2))
    grains.remember(memory)
