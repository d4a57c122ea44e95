"""Grains as the main loop sees them: an integrator whose steps lead from one look at the fields to the next."""

from __future__ import annotations

import math
from collections import deque
from typing import Any, ClassVar, NamedTuple

import numpy as np

from hydro.accounts import COLLISIONS, FRICTION, SOURCE, WALL
from hydro.choices import DRIVES, GRAIN_WALLS
from hydro.deck import GrainsDeck
from hydro.dynamics.integrator import Integrator
from hydro.errors import Complaint, DeckError, RunFailed
from hydro.grains import books, walls
from hydro.grains.cells import arena
from hydro.grains.dynamics import Dynamics, kept_places
from hydro.grains.fields import density_scale, fields
from hydro.grains.placement import number_of_grains, placed, too_few
from hydro.initial import initial_state
from hydro.initial.checkpoint import FromCheckpoint, checkpoint_of
from hydro.setup import mesh_of
from hydro.state import State

SAMPLES = 40  # looks at the fields that make an average
OVERLAP = 1e-9  # of grains that were kept, in diameters, or with walls in L_x: more than round-off


def elastic(deck: Any) -> walls.ElasticWall:
    """The wall that only reflects."""
    return walls.ElasticWall()


def thermal(deck: Any) -> walls.ThermalWall:
    """The wall that holds its temperature."""
    return walls.ThermalWall(deck.wall.temperature)


def vibrating(deck: Any) -> Any:
    """The wall that vibrates as the deck says, or does not."""
    return DRIVES[deck.grains.drive](deck) if deck.wall_speed > 0.0 else elastic(deck)


def random_phase(deck: Any) -> walls.RandomPhaseWall:
    """One that is at rest, and gives what one of random phase would."""
    return walls.RandomPhaseWall(deck.wall_speed)


def sinusoidal(deck: Any) -> walls.SinusoidalWall:
    """The wall that vibrates as it does in the experiment."""
    amplitude, omega = deck.moving_wall
    return walls.SinusoidalWall(amplitude, omega, 2.0 * math.pi / omega)


def sawtooth(deck: Any) -> walls.SawtoothWall:
    """One of the same amplitude and period, that always comes."""
    amplitude, omega = deck.moving_wall
    return walls.SawtoothWall(amplitude, 2.0 * math.pi / omega)


def wall_kind(deck: GrainsDeck) -> str:
    """Which driving wall the grains of a deck meet."""
    if deck.wall.kind != "vibrating":
        return deck.wall.kind
    return deck.grains.drive if deck.wall_speed > 0.0 else "elastic"


def first_dynamics(deck: GrainsDeck) -> Dynamics:
    """The grains that a deck begins with: those of a checkpoint of grains, or placed by its initial state.

    DeckError where they do not fit.
    """
    kept = kept_grains(deck)
    if kept is None:
        return dynamics_of(deck, initial_state(deck))
    positions, velocities = kept
    try:
        grains = dynamics_from(deck, positions, velocities)
    except ValueError as error:
        raise DeckError([Complaint("initial.path", str(error))], "initial state") from error
    reach = 1.0 + (deck.moving_wall or (0.0,))[0]  # where a moving wall begins
    out = np.abs(grains.places / (0.5 * reach, 0.5 * deck.box.aspect_ratio) - 1.0).max() - 1.0
    for wrong, problem in (
        (out > OVERLAP, "some of its grains lie out of the box, for the walls of that were others"),
        (
            grains.smallest_gap < -OVERLAP,
            f"its grains overlap with the diameter {deck.diameter:g} by {-grains.smallest_gap:.2g} of it",
        ),
    ):
        if wrong:
            raise DeckError([Complaint("initial.path", problem)], "initial state")
    return grains


def kept_grains(deck: GrainsDeck) -> tuple[np.ndarray, np.ndarray] | None:
    """Positions and velocities, (N, 2) each, where the deck starts from a checkpoint of grains; else None.

    DeckError where the box is another, or the deck asks for another number of them.
    """
    initial = deck.initial
    if not isinstance(initial, FromCheckpoint):
        return None
    saved = checkpoint_of(deck)
    if "motion" not in saved.memory:
        return None
    number = number_of_grains(deck.gas.f, deck.diameter, deck.box.aspect_ratio)
    positions, velocities = kept_places(saved.memory), saved.memory["motion"][:, 2:4]
    for key, wrong, problem in (
        ("initial.refill", initial.refill, "grains of a checkpoint are taken as they are"),
        ("initial.perturbation", initial.perturbation is not None, "grains of a checkpoint are taken as they are"),
        ("initial.path", len(positions) != number, f"it has {len(positions)} grains, and the deck {number}"),
    ):
        if wrong:
            raise DeckError([Complaint(key, problem)], "initial state")
    return positions, velocities


def beginning(deck: GrainsDeck) -> tuple[float, float]:
    """Mean density and temperature that the grains of a deck begin with; DeckError as of `first_dynamics`.

    The density is gas.f where the grains are those of a checkpoint, which are as many as that asks for.
    """
    if kept_grains(deck) is not None:
        grains = first_dynamics(deck)
        return deck.gas.f, grains.energy / grains.number
    state = initial_state(deck)
    mean = state.mass / deck.box.aspect_ratio
    if (number := number_of_grains(mean, deck.diameter, deck.box.aspect_ratio)) < 2:
        raise DeckError([Complaint("gas.f", too_few(number, deck.diameter))], "initial state")
    return mean, float(state.temperature.mean())


def dynamics_of(deck: GrainsDeck, state: State) -> Dynamics:
    """The grains of a deck, with the fields of its initial state. DeckError where they do not fit."""
    diameter, length_y = deck.diameter, deck.box.aspect_ratio
    number, wanted = number_of_grains(state.mass / length_y, diameter, length_y), deck.grains.number
    if wanted is not None and wanted != number:
        problem = f"{wanted} is not allowed; the initial state {deck.initial.kind!r} has {number} grains"
        raise DeckError([Complaint("grains.number", problem, wanted)], "initial state")
    try:
        return dynamics_from(deck, *placed(state, number, diameter, deck.grains.seed))
    except ValueError as error:
        key = "gas.f" if wanted is None else "grains.number"
        raise DeckError([Complaint(key, str(error), wanted)], "initial state") from error


def dynamics_from(deck: GrainsDeck, positions: np.ndarray, velocities: np.ndarray) -> Dynamics:
    """The grains of a deck, where they are told to be; shapes (N, 2). ValueError where the box has too few cells."""
    wall = GRAIN_WALLS[deck.wall.kind](deck)
    periodic = mesh_of(deck).periodic
    box = arena(deck.diameter, deck.restitution, deck.box.aspect_ratio, periodic, deck.grains.contact_time)
    return Dynamics(box, wall, positions, velocities, deck.grains.seed)


def dynamics_again(deck: GrainsDeck, memory: dict[str, np.ndarray]) -> Dynamics:
    """The grains of a deck as `Dynamics.memory` has kept them."""
    motion = memory["motion"]
    grains = dynamics_from(deck, motion[:, :2], motion[:, 2:4])
    grains.remember(memory)
    return grains


class Sample(NamedTuple):
    """One look at the grains: time, fields (4, nx, ny), and what has been summed by then."""

    time: float
    conserved: np.ndarray
    virial: float


# What a checkpoint calls the parts of looks.
LOOKS = {"look_times": "time", "look_fields": "conserved", "look_virials": "virial"}


class GrainsIntegrator(Integrator):
    """Advances grains and the fields that they make; keeps the latest looks at them, for averages."""

    accounts = (WALL, COLLISIONS, FRICTION, SOURCE)  # those of flow, so that the books of both have the same names
    step_limits = ("look",)
    remembered: ClassVar = {
        **Dynamics.remembered,
        "look_times": ("times of the looks that averages are taken over", "L_x/T_*^(1/2)"),
        "look_fields": (
            "fields of looks: density, momentum along x and y, energy",
            "n_c, n_c T_*^(1/2), n_c T_*",
        ),
        "look_virials": ("the virial at looks", "a grain's mass times T_*"),
    }

    def __init__(self, grains: Dynamics, window: float):
        self.grains, self._interval = grains, window / SAMPLES
        self.samples: deque[Sample] = deque(maxlen=SAMPLES)

    def limits(self, state: State) -> dict[str, float]:
        """To the next look."""
        return {"look": self._interval}

    def step(self, state: State, dt: float) -> dict[str, float]:
        """Run all events in `dt` and take the fields; what walls gave and collisions took is summed event by event.

        RunFailed by a collapse leaves grains and state as they were.
        """
        before, kept = self._exchanged(), self.grains.memory()
        try:
            self.grains.advance(state.time + dt)
        except RunFailed:
            self.grains.remember(kept)
            raise
        state.time += dt
        state.conserved[:] = fields(self.grains, state.mesh)
        self.samples.append(Sample(state.time, state.conserved.copy(), self.grains.sum(books.VIRIAL)))
        wall, lost = (self._exchanged() - before).tolist()
        return {"wall": wall, "collisions": lost}

    def _exchanged(self) -> np.ndarray:
        """Energy that the driving wall has given so far, and that collisions have taken."""
        sums = np.array([self.grains.sum(which) for which in (books.WALL_ENERGY, books.LOSS)])
        return sums / density_scale(self.grains.arena.diameter)

    def work(self, steps: int) -> tuple[int, str]:
        """Collisions: a step is a look, of which there are few."""
        return self.grains.count(books.COLLISIONS), "collisions"

    def memory(self) -> dict[str, np.ndarray]:
        """The grains, and the looks at them."""
        looks = {name: np.array([getattr(sample, field) for sample in self.samples]) for name, field in LOOKS.items()}
        return {**self.grains.memory(), **looks}

    def remember(self, memory: dict[str, np.ndarray]) -> None:
        """Take back what `memory` gave."""
        self.grains.remember(memory)
        times, fields_seen, virials = (memory[name] for name in LOOKS)
        self.samples.clear()
        self.samples.extend(map(Sample, times.tolist(), fields_seen, virials.tolist()))
