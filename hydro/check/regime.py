"""Where a deck lies: beside the marginal curve, and within the assumptions that the paper's equations rest on.

Both are judged by the extended state of the deck's gas, as dense as it is on average: docs/experiment.md.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from hydro.choices import WALL_CONDITIONS
from hydro.deck.experiment import Scaled
from hydro.deck.sections import GAMMA
from hydro.errors import RunFailed
from hydro.setup import gas_of, grain_diameter, wall_of
from hydro.steady.extended import ExtendedState, extended_state
from hydro.steady.marginal import critical_aspect_ratio
from hydro.steady.uniform_pressure import UniformPressure
from hydro.walls import VibratingWall

SMALL = (0.1, 0.3)  # what has to be small is good below the first, and violated from the second on
# n/n_c at which hard disks freeze and have melted: areas covered of 0.700 and 0.716, Bernard and Krauth, Phys. Rev.
# Lett. 107, 155704 (2011)
FLUID = (0.77, 0.79)


class Place(NamedTuple):
    """A point in the plane of the marginal curves."""

    L: float
    f: float
    aspect_ratio: float

    def __str__(self) -> str:
        return f"L = {self.L:.6g}, f = {self.f:.4g}, aspect ratio {self.aspect_ratio:.4g}"


class Vibration(NamedTuple):
    """How a wall moves."""

    amplitude: float  # A/L_x
    frequency: float  # omega


@dataclass(frozen=True)
class Grains:
    """What a deck says of its grains and its driving wall, whatever the place; scaled units."""

    wall: Any
    tau: float
    diameter: float  # d/L_x
    gamma: float
    experiment: Scaled | None
    moving: Vibration | None = None  # of a deck whose grains meet a wall that moves

    @classmethod
    def of(cls, deck: Any) -> Grains:
        """Those of a deck with gas and wall."""
        gas, moving = deck.gas, getattr(deck, "moving_wall", None)
        vibration = None if moving is None else Vibration(*moving)
        return cls(wall_of(deck), gas.tau, grain_diameter(deck), gas.gamma, deck.scaled, vibration)

    @classmethod
    def of_experiment(cls, scaled: Scaled) -> Grains:
        """Those of an experiment, before its vibrating wall."""
        return cls(VibratingWall(scaled.K * scaled.W), scaled.tau, scaled.K / scaled.mu, GAMMA, scaled)

    @property
    def strength(self) -> float | None:
        """That of a vibrating wall; None for walls of other kinds."""
        return getattr(self.wall, "strength", None)

    @property
    def driving(self) -> bool:
        """Whether the wall gives heat."""
        return hasattr(self.wall, "face") and self.strength != 0.0

    @property
    def vibration(self) -> Scaled | Vibration | None:
        """What holds amplitude and frequency of the wall, where they are known."""
        return self.experiment or self.moving if self.strength else None

    def inelasticity(self, L: float) -> float:
        """1 - r^2 = (3 gamma/32) L (d/L_x)^2, from the definition of L."""
        return 3.0 * self.gamma / 32.0 * L * self.diameter * self.diameter


@dataclass(frozen=True)
class Stripe:
    """The extended state of a place, with its grains; no `state` where the wall drives, or collisions cool, nothing.

    All but the inelasticity takes a state.
    """

    place: Place
    grains: Grains
    state: Any

    @property
    def wall_density(self) -> float:
        """n at the driving wall."""
        return self.state.wall_density[1]

    @property
    def wall_temperature(self) -> np.float64:
        """T at the driving wall."""
        return np.float64(self.state.temperature_at(1.0, self.grains.wall))

    @property
    def free_path(self) -> np.float64:
        """Mean free path at the driving wall, in L_x."""
        return np.float64(self.grains.diameter * self.state.gas.mean_free_path(self.wall_density))

    @property
    def inelasticity(self) -> float:
        """1 - r^2."""
        return self.grains.inelasticity(self.place.L)

    @property
    def amplitude(self) -> float | None:
        """A/l."""
        vibration = self.grains.vibration
        return None if vibration is None else vibration.amplitude / self.free_path

    @property
    def collisions(self) -> float | None:
        """T^(1/2)/(l omega): collisions of a grain near the wall in the time 1/omega."""
        vibration = self.grains.vibration
        return None if vibration is None else self.wall_temperature**0.5 / (self.free_path * vibration.frequency)

    @property
    def wall_speed(self) -> float | None:
        """A omega/T^(1/2), from the strength (2/pi)^(1/2) A^2 omega^2/T_* of the wall."""
        strength = self.grains.strength
        return None if strength is None else ((math.pi / 2.0) ** 0.5 * strength / self.wall_temperature) ** 0.5

    @property
    def friction(self) -> float:
        """Loss to a friction -v/tau on every grain over the loss in collisions, in the whole box."""
        return self._friction(lambda T: T)

    @property
    def rolling_friction(self) -> float | None:
        """The same for grains that friction slows down at a constant rate; tau is that of grains of speed A omega."""
        experiment = self.grains.experiment
        return None if experiment is None else self._friction(lambda T: T**0.5 * experiment.wall_speed)

    @property
    def temperature_jump(self) -> float:
        """l (dT/dx)/T at the driving wall."""
        return float(self.state.knudsen_at(1.0, self.grains.diameter))

    @property
    def cluster_density(self) -> float:
        """n at the elastic wall."""
        return self.state.wall_density[0]

    def _friction(self, loss: Callable[[Any], Any]) -> float:
        """(2/tau) int n loss(T) dx over int I dx; 2 T is the mean square of a grain's velocity."""
        state, disks = self.state, UniformPressure.of(self.state.gas)
        p = np.float64(state.pressure(self.grains.wall))
        friction = state.average(lambda w: disks.density(w) * loss(p * disks.temperature(w)))
        collisions = state.average(lambda w: np.exp(0.5 * w) * disks.cooling(w)) * p**1.5
        return 2.0 * friction / (np.float64(self.grains.tau) * disks.conduction * disks.loss * collisions)


class Assumption(NamedTuple):
    """What the paper's equations ask for: a ratio that has to be small, and what it means when it is not."""

    name: str
    formula: str
    ratio: Callable[[Stripe], float | None]
    otherwise: str
    limits: tuple[float, float] = SMALL
    of_state: bool = True  # whether it is one about the extended state, not about grains alone

    def verdict(self, ratio: float) -> str:
        """good, marginal or violated."""
        good, violated = self.limits
        return "good" if ratio < good else "marginal" if ratio < violated else "violated"

    def row(self, ratio: float) -> str:
        """Name, formula, ratio, verdict, and what the verdict goes by."""
        good, violated = self.limits
        limits = f"good below {good:g}, violated from {violated:g}"
        return f"{self.name:<27} {self.formula:<28} {ratio:<10.3g} {self.verdict(ratio):<9} {limits}"

    def warnings(self, ratio: float) -> list[str]:
        """What it means that the assumption is violated, if it is."""
        return [f"warning: {self.formula} = {ratio:.3g}: {self.otherwise}"] if self.verdict(ratio) == "violated" else []


ASSUMPTIONS = (
    Assumption(
        "nearly elastic grains",
        "1 - r^2",
        lambda stripe: stripe.inelasticity,
        "the closures hold for nearly elastic grains; it goes like L (K/mu)^2, and no grains have more than 1",
        of_state=False,
    ),
    Assumption(
        "small amplitude",
        "A/l at x=1",
        lambda stripe: stripe.amplitude,
        "the wall moves the gas as a whole, not grain by grain",
    ),
    Assumption(
        "fast vibration",
        "T^(1/2)/(l omega) at x=1",
        lambda stripe: stripe.collisions,
        "grains that come back to the wall find its phase correlated with their last visit",
    ),
    Assumption(
        "slow wall",
        "A omega/T^(1/2) at x=1",
        lambda stripe: stripe.wall_speed,
        "the wall gives about 1 + A^2 omega^2/(8 T) times the heat (2/pi)^(1/2) A^2 omega^2 n T^(1/2); "
        "steady densities do not depend on it",
    ),
    Assumption(
        "dilute at the driving wall",
        "n at x=1",
        lambda stripe: stripe.wall_density,
        "the wall's heat flux is that into a dilute gas",
    ),
    Assumption(
        "weak friction",
        "int 2 n T/tau over int I",
        lambda stripe: stripe.friction,
        "friction takes a share of the heat that the steady states and the heat equation do not know of",
    ),
    Assumption(
        "weak rolling friction",
        "int n mu_r g <v> over int I",
        lambda stripe: stripe.rolling_friction,
        "friction takes a share of the heat that the steady states and the heat equation do not know of: "
        "shake harder, so that T rises",
    ),
    Assumption(
        "no temperature jump",
        "l (dT/dx)/T at x=1",
        lambda stripe: stripe.temperature_jump,
        "at the driving wall the gas is not in local equilibrium, and its temperature jumps",
    ),
    Assumption(
        "fluid cluster",
        "n at x=0",
        lambda stripe: stripe.cluster_density,
        "disks crystallize there, and the equation of state is an interpolation",
        FLUID,
    ),
)


def stripe_of(deck: Any, place: Place) -> Stripe:
    """The extended state of a deck's gas at a place."""
    grains = Grains.of(deck)
    gas = gas_of(deck, L=place.L)
    driven = gas.conducts() and deck.wall.kind in WALL_CONDITIONS and grains.driving
    return Stripe(place, grains, extended_or_none(gas, place.f) if driven else None)


def extended_or_none(gas: Any, f: float) -> ExtendedState | None:
    """The extended state, where there is one."""
    try:
        return extended_state(gas, f)
    except RunFailed:
        return None


def regime(deck: Any, places: Iterable[Place]) -> list[str]:
    """Lines on where a deck with gas and wall lies: at one place, or at the ends of what it goes along."""
    stripes = [stripe_of(deck, place) for place in places]
    periodic = "y" in getattr(deck.box, "periodic", ())
    return [*(position(stripe.state, stripe.place, deck.wall.kind, periodic) for stripe in stripes), *verdicts(stripes)]


@np.errstate(all="ignore")  # what is not a number ends as a failed search
def position(state: ExtendedState | None, place: Place, wall: str, periodic: bool = False) -> str:
    """A line on the place beside the marginal curve; a periodic box has room for whole waves only."""
    before = f"{place}, {wall} wall"
    if state is None:
        driven = f"a wall that is {' or '.join(WALL_CONDITIONS)}"
        return f"{before}: no extended state, for that takes conduction, losses and {driven}"
    try:
        critical = critical_aspect_ratio(state, wall, 2 if periodic else 1).aspect_ratio
    except RunFailed as error:
        return f"{before}: {error}"
    if critical is None:
        return f"{before}: outside the tongue, the extended state is stable for every aspect ratio"
    where, fate = ("inside", "unstable") if place.aspect_ratio > critical else ("outside", "stable")
    ratio = f"the aspect ratio is {place.aspect_ratio / critical:.3g} of the critical {critical:.4g}"
    return f"{before}: {where} the tongue, the extended state is {fate}; {ratio}"


@np.errstate(all="ignore")  # what is not a number is no good
def verdicts(stripes: Iterable[Stripe]) -> list[str]:
    """A line for each assumption with the largest of its ratios, and a warning for each that is violated."""
    rows, warnings = ["assumptions, in the extended state"], []
    for assumption in ASSUMPTIONS:
        asked = [stripe for stripe in stripes if stripe.state is not None or not assumption.of_state]
        ratios = [ratio for ratio in map(assumption.ratio, asked) if ratio is not None]
        if ratios:
            rows.append(assumption.row(max(ratios)))
            warnings += assumption.warnings(max(ratios))
    return rows + warnings
