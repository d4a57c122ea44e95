"""The problems of the benchmarks, as hydro sees them."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numba
import numpy as np

from hydro.driver.march import Run, advance, march
from hydro.dynamics import Godunov
from hydro.dynamics.integrator import Integrator
from hydro.dynamics.lagrange import LagrangeRemap
from hydro.exact import SimpleWave, cell_averages
from hydro.gas import Grossman, HardDisks
from hydro.mesh import Mesh
from hydro.state import State
from hydro.terms import Friction
from hydro.walls import VibratingWall

F, L, K, W, TAU = 0.0235, 5e4, 2e-3, 114.0, 200.0  # typical of Fig. 4 of the paper
RIPPLE = 0.05  # amplitude of the density ripple of the timed problems
BURST = 0.05  # seconds of steps from one fresh copy of the initial state
WARM_UP = 2
GAMMA = 2.0  # two translational degrees of freedom


class Case:
    """The speed of hydro on a problem, with so many threads."""

    def __init__(self, n: int, kind: str, threads: int = 1):
        numba.set_num_threads(threads)
        self.cells, self.threads = n * n, threads
        self.start, self.integrator = problem(n, kind)
        self._memory = self.integrator.memory()
        self._burst = max(2, n // 4)  # far from the breaking of the wave
        self._run(WARM_UP)
        self._burst = min(self._burst, max(2, round(BURST / self._run(1))))

    def rate(self, least_seconds: float) -> float:
        """Cell-steps per second, measured for at least so long."""
        numba.set_num_threads(self.threads)
        seconds, steps = 0.0, 0
        while seconds < least_seconds:
            seconds += self._run(self._burst)
            steps += self._burst
        return self.cells * steps / seconds

    def _run(self, steps: int) -> float:
        """Seconds for so many steps from the initial state, the choice of each step included."""
        state = self.start.copy()
        self.integrator.remember(self._memory)
        start = time.perf_counter()
        run = Run(state, self.integrator, math.inf)
        for _ in range(steps):
            advance(run, math.inf)
        return time.perf_counter() - start


def problem(n: int, kind: str) -> tuple[State, Integrator]:
    """n x n cells: the hydrodynamic update alone ("ideal", periodic) or with heat, friction and wall ("full").

    Both by `godunov`; "implicit" is the second by `lagrange-remap`.
    """
    ideal = kind == "ideal"
    mesh = Mesh.rectangle((n, n), periodic=(ideal, ideal))
    state = rippled(granular_gas(0.0 if ideal else K), mesh)
    method = LagrangeRemap if kind == "implicit" else Godunov
    wall, terms = VibratingWall(strength=0.0 if ideal else K * W), () if ideal else (Friction(TAU),)
    return state, method(state.gas, wall, mesh, terms)


def granular_gas(K: float = 0.0) -> Grossman:
    """The gas of the paper; without K, ideal flow."""
    return Grossman(L, K)


def rippled(gas, mesh: Mesh) -> State:
    """Uniform temperature, at rest, with a smooth two-dimensional ripple of the density."""
    x, y = (2.0 * np.pi * centres for centres in (mesh.x[:, None], mesh.y[None, :]))
    return State.of(gas, mesh, F * (1.0 + RIPPLE * np.cos(x) * np.cos(y)), 1.0)


class IdealGas(HardDisks):
    """p = n T with internal energy T per grain, the dilute limit: an ideal gas of GAMMA, as pyro has. Not compiled.

    (Another gamma would be p = (gamma-1) n T, but hydro's exact solutions hold only for closures with p/(n T) = 1
    in vacuum.)
    """

    def packing_density(self):
        """It never packs."""
        return math.inf

    def compressibility(self, n):
        """p/(n T)."""
        return np.ones_like(n)

    def compressibility_slope(self, n):
        """d(p/(n T))/dn."""
        return np.zeros_like(n)


@dataclass(frozen=True)
class WaveCase:
    """A simple wave of finite amplitude along x in the periodic unit square, to half its breaking time."""

    gas: Any
    amplitude: float = 0.1

    @cached_property
    def wave(self) -> SimpleWave:
        """The exact solution; the mean pressure is that of the granular gas at T = 1, whatever the gas."""
        pressure = granular_gas().pressure(F, 1.0)
        return SimpleWave(self.gas, F, float(self.gas.temperature(F, pressure)), self.amplitude)

    @property
    def end(self) -> float:
        return 0.5 * self.wave.breaking_time

    def initial(self, n: int) -> np.ndarray:
        """Cell averages (4, n, n) of the conserved fields at the start."""
        density, momentum, energy = self._averages(n, 0.0)
        return np.array([np.tile(field[:, None], (1, n)) for field in (density, momentum, 0.0 * density, energy)])

    def error(self, density: np.ndarray) -> float:
        """L1 error of the density (n, n) at the end, over the mean density."""
        exact = self._averages(density.shape[0], self.end)[0]
        return float(np.abs(density - exact[:, None]).mean() / F)

    def march(self, n: int, options: dict[str, Any]) -> tuple[float, float]:
        """Seconds that hydro takes on n x n cells with one thread, and its error."""
        numba.set_num_threads(1)
        mesh = Mesh.rectangle((n, n), periodic=(True, True))
        state = State(self.gas, mesh, self.initial(n))
        integrator = Godunov(self.gas, VibratingWall(strength=0.0), mesh, **options)
        start = time.perf_counter()
        march(state, integrator, self.end)
        return time.perf_counter() - start, self.error(state.density)

    def _averages(self, n: int, t: float) -> np.ndarray:
        faces = np.linspace(0.0, 1.0, n + 1)
        return cell_averages(lambda x: self.wave.conserved(x, t), faces)
