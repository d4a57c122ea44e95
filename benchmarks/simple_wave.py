"""Time to equal error: both codes run a simple wave, each in its own gas."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from statistics import median

import numpy as np
from cases import GAMMA, IdealGas, WaveCase, granular_gas
from pyro_client import Pyro

from hydro.markdown import table

REPEATS = 3  # of hydro's runs, up to
REPEATED = 256  # cells a side

Runner = Callable[[int], tuple[float, float]]  # cells a side -> (seconds, error)


class HydroWave:
    """hydro with the given options, in the granular gas."""

    def __init__(self, options: dict[str, str]):
        self._case, self._options = WaveCase(granular_gas()), options
        self._case.march(32, options)

    def __call__(self, n: int) -> tuple[float, float]:
        runs = [self._case.march(n, self._options) for _ in range(REPEATS if n <= REPEATED else 1)]
        return median(seconds for seconds, _ in runs), runs[0][1]


class PyroWave:
    """pyro2 with the given runtime parameters, in an ideal gas."""

    def __init__(self, pyro: Pyro, parameters: dict[str, float]):
        self._case, self._pyro, self._parameters = WaveCase(IdealGas()), pyro, parameters

    def __call__(self, n: int) -> tuple[float, float]:
        self._pyro.setup(self._case.initial(n), GAMMA, self._parameters)
        seconds = self._pyro.until(self._case.end)
        return seconds, self._case.error(self._pyro.density())


@dataclass
class Wave:
    """Times and errors of one code, grid by grid."""

    name: str
    sizes: list[int] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    errors: list[float] = field(default_factory=list)

    def add(self, n: int, seconds: float, error: float) -> None:
        """One more grid, finer than the last."""
        self.sizes.append(n)
        self.seconds.append(seconds)
        self.errors.append(error)

    @property
    def orders(self) -> tuple[float, float]:
        """(p, q) of the fits error ~ N^-p and time ~ N^q."""
        logs = np.log(self.sizes)
        return -np.polyfit(logs, np.log(self.errors), 1)[0], np.polyfit(logs, np.log(self.seconds), 1)[0]

    def seconds_at(self, error: float) -> float:
        """Time to this error: linear in the logarithms between the grids that enclose it, or the nearest two."""
        x, y = np.log(self.errors), np.log(self.seconds)
        above = int(np.clip(np.searchsorted(-x, -math.log(error)), 1, len(x) - 1))
        slope = (y[above] - y[above - 1]) / (x[above] - x[above - 1])
        return math.exp(y[above] + slope * (math.log(error) - x[above]))


def wave_runs(runners: Mapping[str, tuple[Runner, Sequence[int]]]) -> dict[str, Wave]:
    """All runs, one grid size after the other, so that the codes are timed close together."""
    waves = {name: Wave(name) for name in runners}
    for n in sorted({n for _, sizes in runners.values() for n in sizes}):
        for name, (run, sizes) in runners.items():
            if n in sizes:
                waves[name].add(n, *run(n))
    return waves


def wave_report(ours: Sequence[Wave], others: Sequence[Wave]) -> str:
    """Tables of times and errors, of orders, and of the ratios of times at the errors that the other code reaches."""
    waves = [*ours, *others]
    runs = [
        [wave.name, f"{n}^2", f"{seconds:.3g}", f"{error:.3g}"]
        for wave in waves
        for n, seconds, error in zip(wave.sizes, wave.seconds, wave.errors, strict=True)
    ]
    orders = [[wave.name, *(f"{power:.2f}" for power in wave.orders)] for wave in waves]
    ratios = [
        [wave.name, f"{n}^2", f"{error:.3g}", *(f"{seconds / our.seconds_at(error):.3g}" for our in ours)]
        for wave in others
        for n, seconds, error in zip(wave.sizes, wave.seconds, wave.errors, strict=True)
    ]
    return "\n\n".join(
        [
            table(["code", "grid", "seconds", "relative L1 error of the density"], runs),
            table(["code", "p in error ~ N^-p", "q in time ~ N^q"], orders),
            "Its time over that of hydro at the same error:",
            table(["code", "grid", "error", *(f"over {our.name}" for our in ours)], ratios),
        ]
    )
