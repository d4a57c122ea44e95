"""Numbers that describe a state: extremes along the wall x = 0, gas density at x = 1, and the like."""

from __future__ import annotations

from typing import Any

import numpy as np

from hydro.mesh import Mesh
from hydro.state import State
from hydro.walls.boundary import wall_heat

# Long name and unit of what the summary says of a state; of the last ones, only of averages over grains.
QUANTITIES = {
    "time": ("time", "L_x/T_*^(1/2)"),
    "wall_max": ("largest density on the wall x = 0", "n_c"),
    "wall_min": ("smallest density on the wall x = 0", "n_c"),
    "half_waves": ("number of half-waves along the wall x = 0, 0 where n is uniform", "1"),
    "gas_density": ("mean density at the wall x = 1", "n_c"),
    "mean_pressure": ("mean pressure", "n_c T_*"),
    "max_speed": ("largest speed of the flow", "T_*^(1/2)"),
    "max_mach": ("largest Mach number", "1"),
    "thermal_energy": ("energy of random motion", "n_c T_* L_x^2"),
    "contrast": ("largest density over the smallest beside x = 1", "1"),
    "wall_max_error": ("standard error of wall_max", "n_c"),
    "wall_min_error": ("standard error of wall_min", "n_c"),
    "gas_density_error": ("standard error of gas_density", "n_c"),
    "thermal_energy_error": ("standard error of thermal_energy", "n_c T_* L_x^2"),
}

CLUSTER = 1.2  # times the mean of n(0, y): what the top of a cluster exceeds at least
LEAST = 1e-12  # density that is none but round-off
UNIFORM = 0.02  # range of n along the wall x = 0, over its mean, up to which a state counts as extended


def snapshot(state: State, wall) -> dict[str, Any]:
    """What the summary says of a state: the first of QUANTITIES; see the functions below."""
    low, high = wall_extremes(state.density, state.mesh)
    return {
        "time": state.time,
        "wall_max": high,
        "wall_min": low,
        "half_waves": half_waves(wall_profile(state.density, state.mesh), state.mesh),
        "gas_density": gas_density(state, wall),
        "mean_pressure": state.mesh.integral(state.pressure) / state.mesh.aspect_ratio,
        "max_speed": float(state.speed.max()),
        "max_mach": float(state.mach.max()),
    }


def wall_extremes(density: np.ndarray, mesh: Mesh) -> tuple[float, float]:
    """Smallest and largest n on the line x = 0, over all y, corners included; `density` has shape (nx, ny).

    Fields are even about an elastic wall: the value there is that of the even parabola through the averages of
    the first two cells. A largest or smallest value between walls is that of the parabola through three cells.
    """
    line = wall_profile(density, mesh)
    inside = np.pad(line, 1, mode="wrap") if mesh.periodic[1] else line
    vertices = np.concatenate([-peaks(-inside), peaks(inside)])
    candidates = [line, vertices[is_density(vertices)]]
    if not mesh.periodic[1]:
        candidates += [even_extrapolation(line, mesh.dy), even_extrapolation(line[::-1], mesh.dy[::-1])]
    values = np.concatenate([np.atleast_1d(part) for part in candidates])
    return float(values.min()), float(values.max())


def is_density(values: np.ndarray) -> np.ndarray:
    """Whether a parabola through averages gives a density of the closures; through noise and jumps it may not.

    Averages themselves may be anything: those of grains are 0 in empty cells, and above n_c where layers of centres lie
    on a wall.
    """
    return (values > LEAST) & (values < 1.0)


def wall_profile(density: np.ndarray, mesh: Mesh) -> np.ndarray:
    """n along the line x = 0, averages over the cells in y, shape (ny,)."""
    return density[0] if mesh.periodic[0] else even_extrapolation(density, mesh.dx)


def cluster_position(density: np.ndarray, mesh: Mesh) -> float:
    """y at which n on the line x = 0 is largest: the vertex of the parabola through three cells there.

    The first such place, if there are several to six digits.
    """
    line = np.pad(wall_profile(density, mesh), 1, mode="wrap" if mesh.periodic[1] else "symmetric")
    top = int(np.argmax(line[1:-1] >= (1.0 - 1e-6) * line.max()))
    below, here, above = line[top : top + 3]
    bend = below - 2.0 * here + above
    offset = 0.5 * (below - above) / bend if bend < 0.0 else 0.0
    return float(mesh.y[top] + offset * mesh.dy[top])


def half_waves(line: np.ndarray, mesh: Mesh) -> int:
    """Number of half-waves across the box of the largest cosine in n(0, y), shape (ny,); 0 where n is about uniform.

    In a box that is periodic in y waves have any phase, and the number is even.
    """
    if np.ptp(line) <= UNIFORM * np.mean(line):
        return 0
    if mesh.periodic[1]:
        return 2 * int(np.argmax(np.abs(np.fft.rfft(line))[1:]) + 1)
    mirrored = np.concatenate([line, line[::-1]])  # its waves are cosines across the box
    return int(np.argmax(np.abs(np.fft.rfft(mirrored))[1:-1]) + 1)


def even_extrapolation(averages: np.ndarray, widths: np.ndarray) -> np.ndarray:
    """Value at s=0 of a + b s^2 with the first two cell averages (along axis 0) of the given widths.

    Where that is no density, the first cell's average.
    """
    near, far = widths[0], widths[0] + widths[1]
    first = near**2 / 3.0
    second = (far**3 - near**3) / (3.0 * widths[1])
    value = averages[0] - (averages[1] - averages[0]) * first / (second - first)
    return np.where(is_density(value), value, averages[0])


def peaks(line: np.ndarray) -> np.ndarray:
    """Heights of the local maxima inside a line of averages over even cells: vertices of parabolas."""
    below, here, above = line[:-2], line[1:-1], line[2:]
    top = (here > below) & (here >= above)
    slope, bend = above[top] - below[top], below[top] - 2.0 * here[top] + above[top]
    return here[top] - slope**2 / (8.0 * bend) - bend / 24.0


def gas_density(state: State, wall) -> float:
    """Mean of n over the face x = 1, with the wall's temperature from its heat law."""
    mesh, density = state.mesh, state.density[-1]
    if mesh.periodic[0] or not state.gas.conducts():
        return float(density @ mesh.dy) / mesh.aspect_ratio
    _, temperature = wall_heat(state.gas, wall, density, state.temperature[-1], 0.5 * mesh.dx[-1])
    face = state.gas.density(state.pressure[-1], temperature)
    return float(face @ mesh.dy) / mesh.aspect_ratio


def clusters(line: np.ndarray, periodic: bool = False) -> np.ndarray:
    """Cells of the largest density of each cluster along the wall x = 0, where n has the averages `line`, shape (ny,).

    A cluster is a stretch of the wall on which n is above its mean over y, if n exceeds CLUSTER times that mean
    somewhere in it: one maximum is counted, the largest, between two places where n falls below the mean.
    """
    start = int(np.argmin(line)) if periodic else 0  # no cluster lies across the seam then
    mean, rolled = line.mean(), np.roll(line, -start)
    inside = np.concatenate([[0], rolled > mean, [0]])
    starts, ends = np.flatnonzero(np.diff(inside) == 1), np.flatnonzero(np.diff(inside) == -1)
    tops = [a + int(np.argmax(rolled[a:b])) for a, b in zip(starts, ends, strict=True)]
    return np.array([(top + start) % line.size for top in tops if rolled[top] > CLUSTER * mean], int)


def arrangement(state: State) -> dict[str, float]:
    """Where the gas is, for a history: the number of clusters along the wall x = 0, and the centre of mass."""
    centre_x, centre_y = centre_of_mass(state)
    number = clusters(wall_profile(state.density, state.mesh), state.mesh.periodic[1]).size
    return {"clusters": number, "centre_x": centre_x, "centre_y": centre_y}


def centre_of_mass(state: State) -> tuple[float, float]:
    """Mean x and y of the grains, in L_x; along a periodic direction, of the box as it is cut at its seam."""
    mesh = state.mesh
    moments = (mesh.integral(state.density * mesh.x[:, None]), mesh.integral(state.density * mesh.y))
    return moments[0] / state.mass, moments[1] / state.mass
