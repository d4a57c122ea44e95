"""Viscosity: decay of sound, heat and shear against their exact rates, a manufactured solution, books and symmetry.

Shear and bulk viscosities are those of kinetic theory (`viscosity = 1`), with walls that bear no shear stress.
"""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np

from hydro.choices import INTEGRATORS
from hydro.driver.march import march
from hydro.dynamics.integrator import Integrator
from hydro.exact import LinearMode, Manufactured, cell_averages, linear_modes
from hydro.gas import Grossman
from hydro.mesh import Mesh
from hydro.state import State
from hydro.steady.growth import growth_of, with_mode
from hydro.steady.localized import SteadyState
from hydro.steady.spectrum import Mode
from hydro.studies.orders import orders
from hydro.terms import Friction, Term, Viscosity
from hydro.verification.claims import Claim, Findings, Row, Table, at_least, at_most, measurement
from hydro.verification.conservation import GAS, TAU, W, cosine, exact_sum, uneven
from hydro.verification.manufactured import END, SOLUTION, WALL, mesh_of
from hydro.verification.setups import ELASTIC, FixedSteps, l1, stepping
from hydro.verification.steady import VIBRATING, state_of
from hydro.walls import VibratingWall

TOPIC = "Viscosity"
SECOND = 1.9
AMPLITUDE = 1e-7
FREE: dict[str, dict[str, float]] = {"godunov": {}, "lagrange-remap": {"tolerance": math.inf}}  # steps are given


def viscous(name: str, gas: Any, wall: Any, mesh: Mesh, *terms: Term, **options: Any) -> Integrator:
    """An integrator of the viscous gas, with further terms."""
    return INTEGRATORS[name](gas, wall, mesh, terms=[*terms, Viscosity()], **options)


@measurement(TOPIC, "Modes")
def modes(full: bool) -> Findings:
    """Small modes of a gas with conduction, friction and viscosity: n = 0.3, T = 1, L = 0, K = 0.02, tau = 5.

    One wave along x in a periodic box, to t = 0.4: L1 errors of n, u, v and T over the amplitude 1e-7, added up,
    against the eigenvectors of the linearized equations. Space and time are refined together.
    The limiter is the default; with `mc` sound has the orders 2.01 and 1.98 from 128 to 512 cells.
    """
    cells = (32, 64, 128, 256) if full else (32, 64, 128)
    every = linear_modes(Grossman(L=0.0, K=0.02), 0.3, 1.0, 5.0, 2.0 * math.pi, 1.0)
    claims: list[Claim] = []
    rows: list[Row] = []
    for name, kind in itertools.product(INTEGRATORS, every):
        errors = [mode_error(name, every[kind], count) for count in cells]
        order = orders([1.0 / count for count in cells], errors)[-1]
        rows.append((name, f"{kind}, s = {every[kind].rate:.3f}", *errors, order))
        claims.append(at_least(TOPIC, f"{kind} mode, {name}: order", "2", order, SECOND))
    header = ("integrator", "mode", *(f"{count} cells" for count in cells), "order")
    return Findings(tuple(claims), (Table("L1 errors over the amplitude.", header, rows),))


def mode_error(name: str, mode: LinearMode, count: int) -> float:
    """Sum of the L1 errors of n, u, v and T over the amplitude."""
    mesh = Mesh.rectangle((count, 4), periodic=(True, True))
    state, wanted = small_mode(mode, mesh, 0.0), small_mode(mode, mesh, 0.4)
    integrator = viscous(name, state.gas, ELASTIC, mesh, Friction(5.0), **FREE[name])
    march(state, stepping(integrator, 0.4 / (3 * count) if name == "lagrange-remap" else None), 0.4)
    pairs = zip((state.density, *state.velocity, state.temperature),
                (wanted.density, *wanted.velocity, wanted.temperature), strict=True)  # fmt: skip
    return sum(l1(mesh, found - expected) for found, expected in pairs) / AMPLITUDE


def small_mode(mode: LinearMode, mesh: Mesh, t: float) -> State:
    """A gas with n = 0.3, T = 1 and a small mode along x."""
    line = AMPLITUDE * cell_averages(lambda x: mode.fields(x, t), mesh.x_faces)
    dn, du, dv, dT = (part[:, None] for part in line)
    return State.of(Grossman(L=0.0, K=0.02), mesh, 0.3 + dn, 1.0 + dT, (du, dv))


@measurement(TOPIC, "Attenuation of sound")
def attenuation(full: bool) -> Findings:
    """Decay of a sound wave in a run, against the classical formula of Stokes and Kirchhoff.

    Amplitudes fall at the rate k^2/(2 n) (eta + zeta + kappa (1/c_v - 1/c_p)) where that is small against c k; c_v = 1,
    and c_p is the ratio of the squares of the adiabatic and the isothermal speed of sound. K = 2e-3, no friction, 128
    cells, over one unit of time, for a dilute gas and a dense one. The shares of conduction, shear and bulk viscosity
    are those of the formula.
    """
    rows: list[Row] = []
    claims: list[Claim] = []
    for n, name in itertools.product((0.05, 0.5), INTEGRATORS):
        shares = classical(n)
        measured, expected = decay_of_sound(name, n), sum(shares)
        rows.append((name, n, *(share / expected for share in shares), expected, measured))
        statement = f"sound at n = {n}, {name}: measured attenuation over the classical one, less 1"
        claims.append(at_most(TOPIC, statement, "0", abs(measured / expected - 1.0), 0.02))
    header = ("integrator", "n", "conduction", "shear", "bulk", "classical", "measured")
    return Findings(tuple(claims), (Table("Attenuation per unit time.", header, rows),))


SOUND = Grossman(L=0.0, K=2e-3)


def classical(n: float) -> tuple[float, float, float]:
    """Shares of conduction, shear and bulk viscosity in the attenuation of sound of wavelength 1 at T = 1."""
    ratio = float(SOUND.sound_speed(n, 1.0)) ** 2 / SOUND.pressure_slopes(n, 1.0)[0]
    eta, zeta = SOUND.viscosities(n, 1.0)
    unit = 2.0 * math.pi**2 / n
    return unit * SOUND.conductivity(n, 1.0) * (1.0 - 1.0 / ratio), unit * eta, unit * zeta


def decay_of_sound(name: str, n: float) -> float:
    """The rate at which the first harmonic of the velocity falls in a run from a small sound wave."""
    mesh, k = Mesh.rectangle((128, 4), periodic=(True, True)), 2.0 * math.pi
    mode = linear_modes(SOUND, n, 1.0, math.inf, k, 1.0)["sound"]
    dn, du, _, dT = (1e-5 * part[:, None] for part in cell_averages(lambda x: mode.fields(x, 0.0), mesh.x_faces))
    state = State.of(SOUND, mesh, n + dn, 1.0 + dT, (du, 0.0))
    harmonic = [abs(np.exp(-1j * k * mesh.x) @ state.velocity[0][:, 0])]
    integrator = viscous(name, SOUND, ELASTIC, mesh, limiter="mc", **FREE[name])
    march(state, stepping(integrator, 5e-4 if name == "lagrange-remap" else None), 1.0)
    harmonic.append(abs(np.exp(-1j * k * mesh.x) @ state.velocity[0][:, 0]))
    return math.log(harmonic[0] / harmonic[1])


@measurement(TOPIC, "Order of the whole method")
def convergence(full: bool) -> Findings:
    """The manufactured solution, with viscosity beside all other terms; else as without it."""
    counts = (16, 32, 64)
    rows: list[Row] = []
    claims: list[Claim] = []
    for name in INTEGRATORS:
        every = [made_up_errors(name, count) for count in counts]
        rows += [(name, count, *errors) for count, errors in zip(counts, every, strict=True)]
        order = orders([1.0 / count for count in counts], [sum(errors) for errors in every])[-1]
        claims.append(at_least(TOPIC, f"manufactured solution, {name}: order", "2", order, SECOND))
    header = ("integrator", "cells in x", "n", "n u", "n v", "e")
    return Findings(tuple(claims), (Table("L1 errors at t = 0.2.", header, rows),))


def made_up_errors(name: str, cells: int) -> list[float]:
    """L1 errors of the four conserved fields."""
    mesh = mesh_of(cells)
    solution = Manufactured(SOLUTION.gas, SOLUTION.tau, SOLUTION.strength, SOLUTION.aspect_ratio, viscosity=1.0)
    state = State(solution.gas, mesh, solution.conserved(mesh, 0.0))
    integrator = INTEGRATORS[name](state.gas, WALL, mesh, solution.terms, **FREE[name])
    march(state, stepping(integrator, END / (2 * cells) if name == "lagrange-remap" else None), END)
    return [l1(mesh, error) for error in state.conserved - solution.conserved(mesh, END)]


@measurement(TOPIC, "Growth with viscosity and without")
def growth(full: bool) -> Findings:
    """Growth of the leading mode of the extended state and of the exchange of mass between two clusters, in runs.

    16 cells in x (32 in the full version), else as for the growth rates without viscosity above; between t = 20 and
    t = 100. Both integrators must find the eigenvalue, with viscosity and without. Viscosity changes the rates, not
    their signs: it is the flow that the slow heat exchange draws along that is another.
    """
    rows: list[Row] = []
    claims: list[Claim] = []
    for what, (wave, sector) in GROWTH_CASES.items():
        for viscosity in (0.0, 1.0):
            cells = 32 if full else 16
            steady = state_of(wave, (cells, cells * max(wave, 1)))
            growths = growth_of(steady, TAU, 1, viscosity)
            mode = next(growth for growth in growths if growth.sector == sector).modes[0]
            wanted = mode.growth_rate.real
            rates = {name: rate_of(name, steady, mode, viscosity) for name in INTEGRATORS}
            rows.append((what, viscosity, f"{wanted:.6f}", *(f"{rate:.6f}" for rate in rates.values())))
            statement = f"{what}, viscosity {viscosity:g}: relative difference of the integrators"
            godunov, implicit = rates.values()
            claims.append(at_most(TOPIC, statement, "0", abs(godunov / implicit - 1.0), 0.02))
            for name, rate in rates.items():
                statement = f"{what}, viscosity {viscosity:g}, {name}: relative difference from the eigenvalue"
                claims.append(at_most(TOPIC, statement, "0", abs(rate / wanted - 1.0), 0.01))
    header = ("mode", "viscosity", "eigenvalue", *INTEGRATORS)
    return Findings(tuple(claims), (Table("Growth rates per unit time.", header, rows),))


GROWTH_CASES = {"extended state, half-wave": (0, "1 half-wave"), "two clusters, exchange of mass": (2, "antisymmetric")}


def rate_of(name: str, steady: SteadyState, mode: Mode, viscosity: float) -> float:
    """The growth rate of a mode, from t = 20 to t = 100; its amplitude is 1e-4 of the density at first."""
    state = with_mode(steady.state, mode, 1e-4)
    integrator = INTEGRATORS[name](
        GAS, VIBRATING, state.mesh, terms=[Friction(TAU), Viscosity(viscosity)], **FREE[name]
    )
    shares = []
    for time in (20.0, 100.0):
        march(state, stepping(integrator, 0.1 if name == "lagrange-remap" else None), time)
        shares.append(state.mesh.integral((state.density - steady.state.density) * mode.density.real))
    return math.log(shares[1] / shares[0]) / 80.0


@measurement(TOPIC, "Books, symmetry and rest")
def books(full: bool) -> Findings:
    """What viscosity must leave as it is: energy, mirror images, steady states.

    The start of a run like Fig. 4, 32 x 64 cells, to t = 20: what is missing in the books over the largest entry. Fifty
    steps from a start without symmetry, and from its mirror image: largest difference. The localized half-wave, 16 x 16
    cells, K = 2e-3, W = 114: relative change of the density in 100 units of time.
    """
    claims: list[Claim] = []
    for name in INTEGRATORS:
        claims += [
            at_most(TOPIC, f"{name}: residual of the energy's books", "round-off", missing_energy(name), 1e-10),
            at_most(TOPIC, f"{name}: y mirrored, difference", "round-off", mirror_difference(name), 1e-12),
            at_most(TOPIC, f"{name}: change of the localized state", "round-off", restlessness(name), 1e-9),
        ]
    return Findings(tuple(claims))


def missing_energy(name: str) -> float:
    """Change of energy less what was exchanged, over the largest of them."""
    mesh = Mesh.rectangle((32, 64), 2.0)
    state = cosine(mesh)
    before = exact_sum(mesh, state.conserved[3])
    given = march(state, viscous(name, GAS, VibratingWall(GAS.K * W), mesh, Friction(TAU)), 20.0).ledger.amounts
    change = exact_sum(mesh, state.conserved[3]) - before
    missing = math.fsum([change, -given["wall"], given["collisions"], given["friction"]])
    return abs(missing) / max(map(abs, (before, change, *given.values())))


def mirror_difference(name: str) -> float:
    """Between a run and the mirror image of the run that starts from the mirror image."""
    mesh, sign = Mesh.rectangle((32, 32), 2.0), np.array([1.0, 1.0, -1.0, 1.0])[:, None, None]
    runs = [uneven(mesh), uneven(mesh)]
    runs[1].conserved = np.ascontiguousarray(sign * runs[1].conserved[:, :, ::-1])
    for state in runs:
        integrator = viscous(name, GAS, VibratingWall(GAS.K * W), mesh, Friction(TAU), **FREE[name])
        march(state, FixedSteps(integrator, 5e-3), 0.25)
    return float(np.max(np.abs(runs[0].conserved - sign * runs[1].conserved[:, :, ::-1])))


def restlessness(name: str) -> float:
    """Largest relative change of the density of a steady state in 100 units of time."""
    state = state_of(1, (16, 16)).state.copy()
    before = state.density.copy()
    march(state, viscous(name, state.gas, VIBRATING, state.mesh, Friction(TAU)), 100.0)
    return float(np.max(np.abs(state.density / before - 1.0)))
