"""Smooth ideal flow: sound of finite amplitude, density carried at uniform pressure, and noise at rest.

Starts and references are exact cell averages. Errors are means of |n - exact average|; the order is that between
the two finest grids. Gas without conduction and cooling (K = L = 0), default time step; lines of cells are one
cell thick unless said otherwise, all sides periodic.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator

import numpy as np
from scipy.interpolate import CubicSpline

from hydro.choices import LIMITERS, RIEMANN_SOLVERS
from hydro.driver.march import Run, advance, march
from hydro.driver.trackers import EachStep
from hydro.exact import DensityWave, SimpleWave, cell_averages, isobaric_profile
from hydro.mesh import Mesh
from hydro.state import State
from hydro.studies.orders import orders
from hydro.verification.claims import Claim, Findings, Row, Table, at_least, at_most, measurement
from hydro.verification.setups import IDEAL, along, godunov, l1, laid

TOPIC = "Waves"
ORDER = 1.9
SECOND_ORDER = ("van_leer", "mc")  # limiters of which second order is claimed; minmod clips too much
NODES, WEIGHTS = np.polynomial.legendre.leggauss(3)
Exact = Callable[[Mesh, float], np.ndarray]  # conserved fields on a mesh at a time


def wave_errors(exact: Exact, meshes: Iterable[Mesh], end: float, **options: str) -> list[float]:
    """L1 errors of the density at `end`."""
    errors = []
    for mesh in meshes:
        state = State(IDEAL, mesh, exact(mesh, 0.0))
        march(state, godunov(mesh, **options), end)
        errors.append(l1(mesh, state.density - exact(mesh, end)[0]))
    return errors


def study(what: str, exact: Exact, meshes: list[Mesh], end: float, solvers: Iterable[str]) -> Findings:
    """Errors and orders of an exact wave for every limiter and the given Riemann solvers."""
    sizes = [float(mesh.areas[0, 0] ** 0.5) if min(mesh.cells) > 1 else 1.0 / max(mesh.cells) for mesh in meshes]
    claims: list[Claim] = []
    rows: list[Row] = []
    for riemann, limiter in itertools.product(solvers, LIMITERS):
        errors = wave_errors(exact, meshes, end, limiter=limiter, riemann=riemann)
        order = orders(sizes, errors)[-1]
        rows.append((riemann, limiter, *errors, order))
        if limiter in SECOND_ORDER:
            claims.append(at_least(TOPIC, f"{what}, {limiter}, {riemann}: order", "2", order, ORDER))
    grids = (" x ".join(map(str, mesh.cells)) for mesh in meshes)
    table = Table(f"{what.capitalize()}: L1 errors.", ("Riemann solver", "limiter", *grids, "order"), rows)
    return Findings(tuple(claims), (table,))


def axis_of(mesh: Mesh) -> int:
    """The direction of a line of cells."""
    return 0 if mesh.cells[0] > 1 else 1


def directed(axis: int, n, momentum, e) -> np.ndarray:
    """Conserved fields on a line of cells along `axis`, from those of one dimension."""
    momenta = (momentum, 0.0 * n) if axis == 0 else (0.0 * n, momentum)
    return laid(axis, np.array([n, *momenta, e]))


def simple_wave() -> SimpleWave:
    """A wave of ten percent in a gas of moderate density."""
    return SimpleWave(IDEAL, 0.3, 1.0, 0.1)


def along_a_line(mesh: Mesh, t: float) -> np.ndarray:
    """The simple wave along a line of cells."""
    faces = (mesh.x_faces, mesh.y_faces)[axis_of(mesh)]
    return directed(axis_of(mesh), *cell_averages(lambda x: simple_wave().conserved(x, t), faces))


@measurement(TOPIC, "Simple wave")
def simple_waves(full: bool) -> Findings:
    """A right-going sound wave, n = 0.3 (1 + 0.1 sin 2 pi x) at the start, up to half of its breaking time.

    The exact solution follows each value of n along its characteristic. Along x with both Riemann solvers, along
    y with the default one.
    """
    cells = (64, 128, 256, 512) if full else (64, 128, 256)
    end = 0.5 * simple_wave().breaking_time
    x = study("simple wave along x", along_a_line, [along(0, count) for count in cells], end, RIEMANN_SOLVERS)
    return x + study("simple wave along y", along_a_line, [along(1, count) for count in cells], end, ["hllc_lm"])


def oblique_exact(wave: SimpleWave, direction: np.ndarray) -> Exact:
    """The wave turned into a unit vector `direction`, averaged over cells by Gauss quadrature.

    One period is evaluated once, and splined: to about 1e-10.
    """
    line = np.linspace(0.0, wave.length, 2049)

    def exact(mesh: Mesh, t: float) -> np.ndarray:
        values = wave.conserved(line, t)
        values[:, -1] = values[:, 0]
        spline = CubicSpline(line, values, axis=1, bc_type="periodic")
        n, momentum, e = np.zeros((3, *mesh.cells))
        for (a, wa), (b, wb) in itertools.product(zip(NODES, WEIGHTS, strict=True), repeat=2):
            x, y = mesh.x + 0.5 * a * mesh.dx, mesh.y + 0.5 * b * mesh.dy
            phase = direction[0] * x[:, None] + direction[1] * y
            point = spline(np.mod(phase, wave.length))
            n, momentum, e = (s + 0.25 * wa * wb * f for s, f in zip((n, momentum, e), point, strict=True))
        return np.array([n, momentum * direction[0], momentum * direction[1], e])

    return exact


@measurement(TOPIC, "Oblique simple wave")
def oblique_wave(full: bool) -> Findings:
    """The same wave with crests at an angle of 63 degrees to the y axis, in a periodic box twice as long in y.

    Cells are square.
    """
    direction = np.array([2.0, 1.0]) / math.sqrt(5.0)
    wave = SimpleWave(IDEAL, 0.3, 1.0, 0.1, length=float(direction[0]))
    counts = (32, 64, 128) if full else (32, 64)
    meshes = [Mesh.rectangle((n, 2 * n), 2.0, periodic=(True, True)) for n in counts]
    solvers = list(RIEMANN_SOLVERS) if full else ["hllc_lm"]
    return study("oblique simple wave", oblique_exact(wave, direction), meshes, 0.5 * wave.breaking_time, solvers)


def carried(mesh: Mesh, t: float) -> np.ndarray:
    """A density wave from 0.1 to 0.5 at pressure 1 that moves with velocity 1."""
    wave, axis = DensityWave(IDEAL, 0.3, 2.0 / 3.0, 1.0, 1.0), axis_of(mesh)
    faces = (mesh.x_faces, mesh.y_faces)[axis]
    return directed(axis, *cell_averages(lambda x: wave.conserved(x, t), faces))


@measurement(TOPIC, "Density wave at uniform pressure")
def density_wave(full: bool) -> Findings:
    """n = 0.3 + 0.2 sin 2 pi x at p = 1, carried half a period with velocity 1 (Mach 0.15 to 0.3)."""
    cells = (64, 128, 256, 512) if full else (64, 128, 256)
    return study("density wave", carried, [along(0, count) for count in cells], 0.5, RIEMANN_SOLVERS)


@measurement(TOPIC, "Noise at rest")
def noise(full: bool) -> Findings:
    """Random pressure of one part in a thousand in a gas at rest: its sound has to fade, not to grow.

    Growth of the root mean square of the velocity from 20 to 1000 default steps, on a line of 64 cells and on
    32 x 32. Uniform gas, n = 0.3. A step that is too large for the scheme shows here first.
    """
    claims: list[Claim] = []
    for cells, riemann, limiter in itertools.product(((64, 1), (32, 32)), RIEMANN_SOLVERS, LIMITERS):
        growth = noise_growth(cells, limiter=limiter, riemann=riemann)
        name = f"noise on {cells[0]} x {cells[1]} cells, {riemann}, {limiter}: growth of velocities"
        claims.append(at_most(TOPIC, name, "below 1", growth, 1.0))
    return Findings(tuple(claims))


def noise_growth(cells: tuple[int, int], **options: str) -> float:
    """Velocities after 1000 steps over those after 20, root mean squares."""
    mesh = Mesh.rectangle(cells, periodic=(True, True))
    ripple = 1.0 + 1e-3 * np.random.default_rng(1).standard_normal(cells)
    state = State.of(IDEAL, mesh, 0.3, ripple)
    integrator = godunov(mesh, **options)
    speeds = []
    run = Run(state, integrator, math.inf)
    for steps in (20, 980):
        for _ in range(steps):
            advance(run, math.inf)
        speeds.append(float(np.sqrt(np.mean(state.speed**2))))
    return speeds[1] / speeds[0]


@measurement(TOPIC, "Slow vortices")
def vortices(full: bool) -> Findings:
    """Four vortices at Mach 0.01 on 32 x 32 cells: kinetic energy left of 1 after 0.3 turnovers.

    They are steady without viscosity: all that is lost is lost by the scheme. Plain HLLC loses most of it, by the
    sound that it damps at every face; this is what the low-Mach correction is for.
    """
    kept = {riemann: energy_kept(0.01, riemann=riemann) for riemann in RIEMANN_SOLVERS}
    claim = at_least(TOPIC, "vortices at Mach 0.01, hllc_lm: kinetic energy kept", "1", kept["hllc_lm"], 0.95)
    return Findings((claim,), (Table("Kinetic energy kept.", ("Riemann solver", "kept"), list(kept.items())),))


def energy_kept(mach: float, **options: str) -> float:
    """Part of the kinetic energy of the vortices that is left."""
    mesh, n, k = Mesh.rectangle((32, 32), periodic=(True, True)), 0.3, 2.0 * np.pi
    speed = mach * float(IDEAL.sound_speed(n, 1.0))
    x, y = mesh.x[:, None], mesh.y
    u, v = speed * np.sin(k * x) * np.cos(k * y), -speed * np.cos(k * x) * np.sin(k * y)
    p = IDEAL.pressure(n, 1.0) + 0.25 * n * speed**2 * (np.cos(2 * k * x) + np.cos(2 * k * y))
    state = State.of(IDEAL, mesh, n, IDEAL.temperature(n, p), (u, v))
    start = mesh.integral(state.kinetic_energy)
    march(state, godunov(mesh, **options), 0.3 / speed)
    return mesh.integral(state.kinetic_energy) / start


PROFILE = (0.004, 0.76)
NOISE = 1e-2
SLOW = 1e-3  # Mach number


def pressure_noise(cells: int, width: int, mach: float, distance: float, **options: str) -> float:
    """Largest max |p/p0 - 1| while the profile is carried over `distance` cells; its walls are `width` cells wide.

    `mach` is the speed over the smallest sound speed in the profile.
    """
    mesh = along(1, cells)
    n = cell_averages(isobaric_profile(*PROFILE, width / cells), mesh.y_faces)
    speed = mach * float(IDEAL.sound_speed_at_pressure(n, 1.0).min())
    state = State.of(IDEAL, mesh, laid(1, n), IDEAL.temperature(laid(1, n), 1.0), (0.0, speed))
    largest = [0.0]
    watch = EachStep(lambda run: largest.append(float(np.max(np.abs(state.pressure - 1.0)))))
    march(state, godunov(mesh, **options), distance / cells / speed, [watch])
    return max(largest)


def averaging_estimate(cells: int, width: int) -> float:
    """max Z (1/Z)''/2 var(n) over the cells: the error in p of a cell whose e is an average and whose n varies."""
    faces = np.linspace(0.0, 1.0, cells + 1)
    profile = isobaric_profile(*PROFILE, width / cells)
    n = cell_averages(profile, faces)
    variance = cell_averages(lambda x: profile(x) ** 2, faces) - n**2
    if width == 0:
        n, variance = np.array([np.mean(PROFILE)]), np.array([(0.5 * np.diff(PROFILE)[0]) ** 2])
    return float(np.max(IDEAL.compressibility(n) * 2.0 / (1.0 + n) ** 3 * variance))


@measurement(TOPIC, "Dense gas carried through dilute gas")
def contacts(full: bool) -> Findings:
    """A band of n = 0.76 in n = 0.004, at uniform pressure p0, carried at Mach 0.1 and 0.001 of its slowest sound.

    max |p/p0 - 1| over cells and steps, on the way over 32 cells; at Mach 0.001, where a cell takes thousands of
    steps, over 4 cells (8 in the full version) and with the van Leer limiter only. The walls of the band are 16
    cells wide on every grid, or jumps (at Mach 0.001 in the full version). At uniform pressure e = p/Z(n) is not
    linear in n, so that a cell which holds the averages of n and e of a mixture has another pressure: p/p0 - 1 is
    about Z (1/Z)'' var(n)/2, with (1/Z)'' = 4/(1+n)^3 and the variance of n inside the cell; for a jump, with n in
    the middle and half the cell on either side.
    """
    grids = (64, 128, 256) if full else (64, 128)
    claims: list[Claim] = []
    rows: list[Row] = []
    for mach, width, riemann, limiter in contact_cases(full):
        distance = 32.0 if mach > SLOW else (8.0 if full else 4.0)
        noise = [pressure_noise(count, width, mach, distance, limiter=limiter, riemann=riemann) for count in grids]
        rows.append((mach, width or "jump", riemann, limiter, *noise, averaging_estimate(grids[-1], width)))
        if width:
            name = f"{width} cells wide, Mach {mach}, {riemann}, {limiter}: pressure noise"
            claims.append(at_most(TOPIC, name, "small", max(noise), NOISE))
    header = ("Mach", "width", "Riemann solver", "limiter", *(f"{count} cells" for count in grids), "estimate")
    return Findings(tuple(claims), (Table("Pressure noise max |p/p0 - 1|.", header, rows),))


def contact_cases(full: bool) -> Iterator[tuple[float, int, str, str]]:
    """(Mach number, width in cells, Riemann solver, limiter) of the runs; width 0 is a jump."""
    yield from itertools.product((0.1,), (16, 0), RIEMANN_SOLVERS, LIMITERS)
    yield from itertools.product((SLOW,), (16, 0) if full else (16,), RIEMANN_SOLVERS, ("van_leer",))
