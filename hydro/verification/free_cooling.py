"""A gas that cools freely: Haff's law while it is uniform, then shear layers and clusters, as linear theory has them.

Rates are in the scaled time s, ds = T^(1/2) dt with the T of Haff's law, in which they are constant:
`hydro/exact/cooling_modes.py`.
"""

from __future__ import annotations

import math

import numpy as np

from hydro.driver.march import march
from hydro.exact import homogeneous_cooling
from hydro.exact.cooling_modes import CoolingMode, cooling_modes, scaled_time
from hydro.gas import Grossman
from hydro.mesh import Mesh
from hydro.state import State
from hydro.terms import Viscosity
from hydro.verification.claims import Claim, Findings, Row, Table, at_most, measurement
from hydro.verification.setups import godunov

TOPIC = "Freely cooling gas"
GAS = Grossman(L=35870.0, K=5e-3)  # d/L_x = 0.005 and r = 0.9 for mu = 1
SMALL = 1e-4
CLOSE = 0.01


def perturbed(mode: CoolingMode, n: float, mesh: Mesh, waves: int) -> State:
    """The uniform gas at T = 1 and a small mode with so many waves along x."""
    wave = np.exp(2j * math.pi * waves * mesh.x)[:, None] * np.ones(mesh.cells)
    r, w, z, h = (SMALL * (amplitude * wave).real for amplitude in mode.amplitudes)
    return State.of(GAS, mesh, n * (1.0 + r), 1.0 + h, (w, z))


def amplitude(state: State, name: str, n: float, waves: int) -> float:
    """That of a mode: of the density over its mean, or of the velocity across over the root of the mean T."""
    T = state.mesh.integral(state.density * state.temperature) / state.mass
    field = state.density / n if name == "clusters" else state.velocity[1] / math.sqrt(T)
    return 2.0 * abs(np.fft.fft(field[:, 0])[waves]) / field.shape[0]


@measurement(TOPIC, "Growth of shear layers and clusters")
def growth(full: bool) -> Findings:
    """One small mode along x in a periodic box, viscosity 1, default time step, until it should have grown by e: the
    rate of its amplitude in s over that of theory, and the temperature over Haff's law.

    L = 35870, K = 0.005, n = 0.2 and 0.4; shear layers with 1 and 3 waves, clusters with 1.
    """
    claims: list[Claim] = []
    rows: list[Row] = []
    cells = 128 if full else 64
    for n in (0.2, 0.4):
        for name, waves in (("shear", 1), ("shear", 3), ("clusters", 1)):
            mode = cooling_modes(GAS, n, 2.0 * math.pi * waves)[name]
            wanted, half = mode.rate.real, GAS.cooling_coefficient(n) / (2.0 * n)
            mesh = Mesh.rectangle((cells, 2), aspect_ratio=2.0 / cells, periodic=(True, True))
            state = perturbed(mode, n, mesh, waves)
            before = amplitude(state, name, n, waves)
            march(state, godunov(mesh, GAS, terms=[Viscosity(1.0)]), math.expm1(half / abs(wanted)) / half)
            grown = math.log(amplitude(state, name, n, waves) / before)
            rate = grown / scaled_time(GAS, n, 1.0, state.time)
            mean = state.mesh.integral(state.density * state.temperature) / state.mass
            haff = abs(mean / homogeneous_cooling(GAS, n, 1.0, state.time) - 1.0)
            rows.append((n, name, waves, wanted, rate, state.time, haff))
            words = f"{name}, {waves} waves, n = {n}, {cells} cells"
            claims.append(at_most(TOPIC, f"{words}: growth rate, relative error", "0", abs(rate / wanted - 1.0), CLOSE))
            claims.append(at_most(TOPIC, f"{words}: mean T over Haff's law, less 1", "0", haff, CLOSE))
    header = ("n", "mode", "waves", "rate in s, theory", "measured", "t at the end", "error of Haff's law")
    return Findings(tuple(claims), (Table("Growth rates in scaled time.", header, rows),))
