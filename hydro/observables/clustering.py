"""The observables of clustering before a driving wall: extremes along the wall x = 0, gas density at x = 1."""

from __future__ import annotations

from typing import Any

import numpy as np

from hydro.mesh import Mesh
from hydro.observables.general import extended
from hydro.observables.sets import Curve, Panel, Quantity, Span
from hydro.state import State
from hydro.walls.boundary import wall_heat

CLUSTER = 1.2  # times the mean of n(0, y): what the top of a cluster exceeds at least
LEAST = 1e-12  # density that is none but round-off
UNIFORM = 0.02  # range of n along the wall x = 0, over its mean, up to which a state counts as extended


def wall_extremes(density: np.ndarray, mesh: Mesh, packed: float = 1.0) -> tuple[float, float]:
    """Smallest and largest n on the line x = 0, over all y, corners included; `density` has shape (nx, ny).

    Fields are even about an elastic wall: the value there is that of the even parabola through the averages of
    the first two cells. A largest or smallest value between walls is that of the parabola through three cells.
    packed: the density at which the gas packs; grains do at n_c.
    """
    line = wall_profile(density, mesh, packed)
    inside = np.pad(line, 1, mode="wrap") if mesh.periodic[1] else line
    vertices = np.concatenate([-peaks(-inside), peaks(inside)])
    candidates = [line, vertices[is_density(vertices, packed)]]
    if not mesh.periodic[1]:
        ends = ((line, mesh.dy), (line[::-1], mesh.dy[::-1]))
        candidates += [even_extrapolation(*end, packed) for end in ends]
    values = np.concatenate([np.atleast_1d(part) for part in candidates])
    return float(values.min()), float(values.max())


def extremes(state: State) -> tuple[float, float]:
    """`wall_extremes` of a state."""
    return wall_extremes(state.density, state.mesh, state.gas.packing_density())


def profile(state: State) -> np.ndarray:
    """`wall_profile` of a state."""
    return wall_profile(state.density, state.mesh, state.gas.packing_density())


def is_density(values: np.ndarray, packed: float) -> np.ndarray:
    """Whether a parabola through averages gives a density of the gas; through noise and jumps it may not.

    Averages themselves may be anything: those of grains are 0 in empty cells, and above n_c where layers of centres lie
    on a wall.
    """
    return (values > LEAST) & (values < packed)


def wall_profile(density: np.ndarray, mesh: Mesh, packed: float = 1.0) -> np.ndarray:
    """n along the line x = 0, averages over the cells in y, shape (ny,)."""
    return density[0] if mesh.periodic[0] else even_extrapolation(density, mesh.dx, packed)


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


def even_extrapolation(averages: np.ndarray, widths: np.ndarray, packed: float) -> np.ndarray:
    """Value at s=0 of a + b s^2 with the first two cell averages (along axis 0) of the given widths.

    Where that is no density, the first cell's average.
    """
    near, far = widths[0], widths[0] + widths[1]
    first = near**2 / 3.0
    second = (far**3 - near**3) / (3.0 * widths[1])
    value = averages[0] - (averages[1] - averages[0]) * first / (second - first)
    return np.where(is_density(value, packed), value, averages[0])


def peaks(line: np.ndarray) -> np.ndarray:
    """Heights of the local maxima inside a line of averages over even cells: vertices of parabolas."""
    below, here, above = line[:-2], line[1:-1], line[2:]
    top = (here > below) & (here >= above)
    slope, bend = above[top] - below[top], below[top] - 2.0 * here[top] + above[top]
    return here[top] - slope**2 / (8.0 * bend) - bend / 24.0


def gas_density(state: State, wall: Any) -> float:
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


def centre_of_mass(state: State) -> tuple[float, float]:
    """Mean x and y of the grains, in L_x; along a periodic direction, of the box as it is cut at its seam."""
    mesh = state.mesh
    moments = (mesh.integral(state.density * mesh.x[:, None]), mesh.integral(state.density * mesh.y))
    return moments[0] / state.mass, moments[1] / state.mass


def last_density(state: State, wall: Any) -> float:
    """Mean of n over the last cells before x = 1."""
    return float(state.density[-1] @ state.mesh.dy) / state.mesh.aspect_ratio


def number_of_clusters(state: State, wall: Any) -> int:
    """How many clusters there are along the wall x = 0."""
    return clusters(profile(state), state.mesh.periodic[1]).size


def contrast(state: State, wall: Any) -> float:
    """The largest density over the smallest of the last cells before x = 1; not a number where one is empty."""
    return float(state.density.max() / (state.density[-1].min() or np.nan))


WALL_MAX = Quantity(
    "wall_max", "largest density on the wall x = 0", "n_c",
    lambda state, _: extremes(state)[1], "largest n(0, y)",
)  # fmt: skip
WALL_MIN = Quantity(
    "wall_min", "smallest density on the wall x = 0", "n_c",
    lambda state, _: extremes(state)[0], "smallest n(0, y)",
)  # fmt: skip
HALF_WAVES = Quantity(
    "half_waves", "number of half-waves along the wall x = 0, 0 where n is uniform", "1",
    lambda state, _: half_waves(profile(state), state.mesh),
)  # fmt: skip
GAS_DENSITY = Quantity(
    "gas_density", "mean density at the wall x = 1", "n_c", gas_density, "n at x = 1", average=last_density
)
CLUSTERS = Quantity("clusters", "number of clusters along the wall x = 0", "1", number_of_clusters)
CENTRE_X = Quantity("centre_x", "mean x of the grains", "L_x", lambda state, _: centre_of_mass(state)[0], "mean x")
CENTRE_Y = Quantity("centre_y", "mean y of the grains", "L_x", lambda state, _: centre_of_mass(state)[1], "mean y")
CONTRAST = Quantity("contrast", "largest density over the smallest beside x = 1", "1", contrast)
POSITION = Quantity(
    "cluster_position", "y of the largest density on the wall x = 0", "L_x",
    lambda state, _: cluster_position(state.density, state.mesh), "y of largest n(0, y)",
)  # fmt: skip

EXTREMES = (Curve("wall_max", "largest, $x=0$"), Curve("wall_min", "smallest, $x=0$", "--"))
CLUSTERING = extended(
    "clustering",
    fits=lambda deck: True,
    summary=(WALL_MAX, WALL_MIN, HALF_WAVES, GAS_DENSITY),
    history=(CLUSTERS, CENTRE_X, CENTRE_Y),
    estimated=(WALL_MAX, WALL_MIN, GAS_DENSITY),
    averages=(CONTRAST,),
    closing=(("wall_max", "wall max", ".4f"), ("wall_min", "min", ".4f"), ("gas_density", "gas", ".5f")),
    compared=(WALL_MAX, WALL_MIN, GAS_DENSITY, POSITION),
    drifting=("wall_max", "wall_min"),
    panels=(
        Panel(
            "Densities at the walls", "density $n/n_c$", (*EXTREMES, Curve("gas_density", "mean, $x=1$", ":")), height=2
        ),
    ),
    overlaid=(
        Panel("Densities", "$n(0,y)/n_c$: largest (full),\nsmallest (dashed)", EXTREMES, height=2),
        Panel("The density at x = 1", "mean $n(1,y)/n_c$", (Curve("gas_density"),)),
        Panel("The centre of mass", "mean $x/L_x$", (Curve("centre_x"),), scale="linear"),
    ),
    span=Span("$n(0,y)$", "on the wall x = 0", wall_extremes, EXTREMES),
)
