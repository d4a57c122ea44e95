"""How fast the explicit integrator is, beside pyro2 and alone: `python benchmarks/explicit.py [--quick]`.

Prints a Markdown report. README.md in this folder says what each part measures.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from statistics import median

import numba
import numpy as np
from cases import GAMMA, Case, granular_gas, rippled
from measure import Triad, interleaved, mega, nanoseconds, processor, ratio
from pyro_client import Pyro, PyroUnavailableError, default_environment
from simple_wave import HydroWave, PyroWave, wave_report, wave_runs

from hydro.markdown import table
from hydro.mesh import Mesh

FRESH, OPERATIONS = (Path(__file__).with_name(name) for name in ("fresh.py", "operations.py"))
COUNTED = 32  # cells along a side on which operations are counted
KINDS = ("ideal", "full")
ALL_KINDS = (*KINDS, "implicit")
PYRO_SETUPS: dict[str, dict[str, float]] = {
    "pyro2, its defaults": {},
    "pyro2, no flattening, no artificial viscosity": {
        "compressible.use_flattening": 0,
        "compressible.cvisc": 0.0,
    },
}
HYDRO_SETUPS: dict[str, dict[str, str]] = {
    "hydro, its defaults": {},
    "hydro, MC limiter and plain HLLC": {"limiter": "mc", "riemann": "hllc"},  # as pyro2
}
STATE_BYTES = 64  # traffic of one cell-step if four float64 fields are read once and written once


@dataclass(frozen=True)
class Effort:
    """How much is measured."""

    rounds: int
    least_seconds: float  # of hydro in one round
    beside: dict[int, int]  # grid size -> pyro steps in one round
    wave_hydro: tuple[int, ...]  # grid sizes of the wave
    wave_pyro: tuple[int, ...]
    sizes: tuple[int, ...]
    memory: tuple[int, int]
    starts: int


FULL = Effort(7, 0.4, {128: 20, 512: 2}, (32, 64, 128, 256, 512), (32, 64, 128, 256),
              (64, 128, 256, 512, 1024, 2048), (512, 1024), 3)  # fmt: skip
QUICK = Effort(3, 0.2, {128: 5, 512: 1}, (32, 64, 128, 256), (32, 64), (64, 256, 1024), (512, 1024), 1)


def throughput(effort: Effort, environment: Path) -> str:
    """Cell-steps per second of both codes on the same grids."""
    with Pyro(environment) as pyro:
        rows = [row for n, steps in effort.beside.items() for row in throughput_on(pyro, n, steps, effort)]
        versions = ", ".join(f"{name} {number}" for name, number in pyro.versions.items())
    return f"pyro2's environment: {versions}.\n\n" + table(
        ["grid", "code", "million cell-steps/s", "ratio to pyro2 with its defaults, median (range)"], rows
    )


def throughput_on(pyro: Pyro, n: int, steps: int, effort: Effort) -> list[list[str]]:
    """Table rows of one grid size; pyro's two setups are measured in one process, each after a fresh start."""
    start = rippled(granular_gas(), Mesh.rectangle((n, n), periodic=(True, True)))
    conserved = np.array([start.density, *start.conserved[1:3], start.pressure / (GAMMA - 1.0)])

    def pyro_rate(parameters: dict[str, float]) -> float:
        pyro.setup(conserved, GAMMA, parameters)
        pyro.steps(1)
        return n * n * steps / pyro.steps(steps)

    cases = [Case(n, kind) for kind in KINDS]
    measures = [lambda p=p: pyro_rate(p) for p in PYRO_SETUPS.values()]
    rates = interleaved(effort.rounds, *measures, *(lambda c=c: c.rate(effort.least_seconds) for c in cases))
    names = [*PYRO_SETUPS, *(f"hydro, {kind}" for kind in KINDS)]
    return [[f"{n}^2", name, mega(rate), ratio(rate, rates[:, 0])] for name, rate in zip(names, rates.T, strict=True)]


def equal_error(effort: Effort, environment: Path) -> str:
    """Times and errors of both codes on a simple wave, and the ratios of times at equal error."""
    with Pyro(environment) as pyro:
        codes = {name: HydroWave(options) for name, options in HYDRO_SETUPS.items()}
        others = {name: PyroWave(pyro, parameters) for name, parameters in PYRO_SETUPS.items()}
        runs = wave_runs({name: (code, effort.wave_hydro) for name, code in codes.items()}
                         | {name: (code, effort.wave_pyro) for name, code in others.items()})  # fmt: skip
    return wave_report([runs[name] for name in codes], [runs[name] for name in others])


def sizes(effort: Effort, _: Path) -> str:
    """Speed of hydro against the grid size, one and two threads."""
    threads = [1, 2] if numba.config.NUMBA_NUM_THREADS > 1 else [1]  # type: ignore[attr-defined]
    triads = [Triad(count) for count in threads]
    bandwidths = np.median(interleaved(5, *(one.bandwidth for one in triads)), axis=0)
    del triads
    columns = [f"{kind}, {count} thr." for kind in KINDS for count in threads] + ["implicit, 1 thr."]
    shares = [f"share of triad, {count} thr." for count in threads]
    rows = [size_row(n, threads, bandwidths, effort) for n in effort.sizes]
    measured = ", ".join(f"{b / 1e9:.3g} GB/s with {count}" for b, count in zip(bandwidths, threads, strict=True))
    return (
        f"Triad bandwidth by threads: {measured}. Share: of the ideal update, if it read and wrote the state "
        f"exactly once ({STATE_BYTES} bytes per cell-step), the least that it can move.\n\n"
        + table(["grid", *columns, *shares], rows)
    )


def size_row(n: int, threads: Sequence[int], bandwidths: np.ndarray, effort: Effort) -> list[str]:
    """Million cell-steps per second of both kinds, and the shares of the bandwidth."""
    cases = [*(Case(n, kind, count) for kind in KINDS for count in threads), Case(n, "implicit")]
    rounds = interleaved(3, *(lambda c=c: c.rate(0.5 * effort.least_seconds) for c in cases))
    rates = np.median(rounds, axis=0)
    shares = STATE_BYTES * rates[: len(threads)] / bandwidths
    return [f"{n}^2", *(f"{rate / 1e6:.3g}" for rate in rates), *(f"{share:.0%}" for share in shares)]


def limits(effort: Effort, _: Path) -> str:
    """What bounds a step: its arithmetic at the measured pace of each operation, and the least traffic."""
    traffic = 1e9 * STATE_BYTES / float(np.median(interleaved(5, Triad(1).bandwidth)))
    paces = [nanoseconds() for _ in range(5)]
    pace = {name: min(one[name] for one in paces) for name in paces[0]}
    header = ["kind", "sums and products per cell-step", "divisions", "roots", "ns per cell-step, measured",
              "arithmetic at best, ns", "traffic at best, ns"]  # fmt: skip
    return (
        f"{COUNTED}^2 cells, one core. Operations are counted in the third step (`operations.py`). At best a sum or "
        f"product takes {pace['sums']:.3f} ns here, a division {pace['divisions']:.2f} ns, a root {pace['roots']:.2f} "
        "ns: vectors in the nearest cache. What these add up to, and the time in which the state is read and written "
        "once at triad bandwidth, are lower bounds. Their shares of the measured time say how near the roofline is, "
        "and the larger share what limits.\n\n"
        + table(header, [limits_row(kind, pace, traffic, effort) for kind in ALL_KINDS])
    )


def limits_row(kind: str, pace: dict[str, float], traffic: float, effort: Effort) -> list[str]:
    """Operations of a step, and its time beside what these and the traffic take at best, in ns per cell."""
    words = [sys.executable, str(OPERATIONS), kind, str(COUNTED)]
    done = json.loads(subprocess.run(words, stdout=subprocess.PIPE, text=True, check=True).stdout)
    case = Case(COUNTED, kind)
    taken = 1e9 / float(np.median(interleaved(5, lambda: case.rate(effort.least_seconds))))
    bounds = (sum(done[name] * pace[name] for name in pace), traffic)
    counts = (done["sums"] + done["products"], done["divisions"], done["roots"])
    return [kind, *(f"{one:.0f}" for one in (*counts, taken)), *(f"{one:.0f} ({one / taken:.0%})" for one in bounds)]


def memory(effort: Effort, _: Path) -> str:
    """Bytes per cell, by the slope of the peak memory between two grids."""
    small, large = effort.memory
    rows = []
    for kind in ALL_KINDS:
        fresh("memory", str(small), kind)  # compiles
        peaks = [fresh("memory", str(n), kind)["bytes"] for n in effort.memory]
        rows.append([kind, f"{(peaks[1] - peaks[0]) / (large**2 - small**2):.0f}"])
    return f"Slope of the peak between {small}^2 and {large}^2 cells.\n\n" + table(["kind", "bytes per cell"], rows)


def starts(effort: Effort, _: Path) -> str:
    """Seconds to the first steps, with an empty and with a full kernel cache."""
    rows = []
    for kind in ALL_KINDS:
        with tempfile.TemporaryDirectory(prefix="hydro-cache-") as cache:
            cold = fresh("start", kind, str(time.time()), cache=cache)
            warm = [fresh("start", kind, str(time.time()), cache=cache) for _ in range(effort.starts)]
        rows += [start_row(kind, "empty", [cold]), start_row(kind, "full", warm)]
    return table(["kind", "kernel cache", "import", "first steps", "then on another mesh"], rows)


def start_row(kind: str, cache: str, runs: Sequence[dict[str, float]]) -> list[str]:
    """Medians of the moments of a start."""
    return [kind, cache, *(f"{median(run[key] for run in runs):.2f}" for key in ("imported", "stepped", "another"))]


def fresh(*words: str, cache: str | None = None) -> dict[str, float]:
    """What fresh.py measures in a process of its own, with a kernel cache of its own if one is given."""
    environment = dict(os.environ)
    if cache is not None:
        environment.pop("NUMBA_CACHE_DIR", None)
        environment["XDG_CACHE_HOME"] = cache
    done = subprocess.run(
        [sys.executable, str(FRESH), *words], env=environment, stdout=subprocess.PIPE, text=True, check=True
    )
    return json.loads(done.stdout)


PARTS: dict[str, tuple[str, Callable[[Effort, Path], str]]] = {
    "throughput": ("Speed beside pyro2, one core", throughput),
    "equal-error": ("Time to equal error beside pyro2, one core", equal_error),
    "sizes": ("Speed against grid size (million cell-steps/s)", sizes),
    "limits": ("What limits a step", limits),
    "memory": ("Memory", memory),
    "starts": ("Seconds from the start of the process", starts),
}


def report(parts: Sequence[str], effort: Effort, environment: Path) -> None:
    """Print the chosen parts; one that needs pyro2 and cannot have it says so."""
    print("## The explicit integrator\n")
    print("Printed by `python benchmarks/explicit.py`.\n")
    print(f"Processor: {processor()}, {os.cpu_count()} cores. Python {platform.python_version()}, "
          f"numba {version('numba')}, numpy {version('numpy')}.\n", flush=True)  # fmt: skip
    for name in parts:
        title, measure = PARTS[name]
        started = time.perf_counter()
        try:
            text = measure(effort, environment)
        except PyroUnavailableError as problem:
            text = f"**Not measured: pyro2 is not available.** {problem}"
        print(f"### {title}\n\n{text}\n\n({time.perf_counter() - started:.0f} s)\n", flush=True)


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="fewer and smaller grids, under two minutes")
    parser.add_argument("--pyro", type=Path, default=default_environment(), metavar="DIR",
                        help="where pyro2 has or gets its virtual environment (default: %(default)s)")  # fmt: skip
    parser.add_argument("parts", nargs="*", metavar="part", help=f"any of {', '.join(PARTS)} (default: all)")
    options = parser.parse_args()
    unknown = set(options.parts) - set(PARTS)
    if unknown:
        parser.error(f"no such part: {', '.join(sorted(unknown))}; there are {', '.join(PARTS)}")
    report(options.parts or list(PARTS), QUICK if options.quick else FULL, options.pyro.absolute())


if __name__ == "__main__":
    main()
