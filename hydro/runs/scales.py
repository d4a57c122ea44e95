"""What an evolution deck means physically: its scales, and where the assumptions behind the equations fail."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hydro.deck import EvolutionDeck
from hydro.deck.sections import Thermal, Vibrating
from hydro.initial import initial_state
from hydro.state import State

# Guesses for run times, good to a factor of two or three on one core of a current processor.
SECONDS_PER_CELL_STEP = {"godunov": 8e-8, "lagrange-remap": 5e-7}
BYTES_PER_CELL = {"godunov": 176, "lagrange-remap": 530}
IMPLICIT_STEPS = 18.0  # over the root of the tolerance, in runs like that of Fig. 4
PAPER_W = 114.0  # the strength of the vibrating wall that keeps it at about T_* in the states of Figs. 3 and 4

NEARLY_ELASTIC = 0.1  # the paper wants 1 - r^2 << 1
DENSE = 0.76  # largest density of the localized states of Figs. 3 and 4
CRYSTAL = 0.77  # n/n_c above which real disks crystallize
FAST = 0.3  # Mach number above which flow is more than a correction


@dataclass(frozen=True)
class Scale:
    """One number that describes the problem."""

    name: str
    value: float
    meaning: str

    def __str__(self) -> str:
        return f"{self.name:<28} {self.value:<12.4g} {self.meaning}"


def report(deck: EvolutionDeck) -> list[str]:
    """Lines on the scales of a deck, and its warnings. DeckError if its initial state is not legal."""
    state = initial_state(deck)
    lines = ["scales (units: L_x, n_c, T_*)", *map(str, scales(deck, state))]
    return lines + [f"warning: {warning}" for warning in warnings(deck, state)]


def scales(deck: EvolutionDeck, state: State) -> list[Scale]:
    """Scales of the deck's gas, walls, mesh and run from its initial state, in scaled units."""
    return [*_grain_scales(deck, state), *_time_scales(deck, state), *_mesh_scales(deck, state)]


def _grain_scales(deck: EvolutionDeck, state: State) -> list[Scale]:
    gas, diameter, mean = deck.gas, grain_diameter(deck), mean_density(state)
    found = [
        Scale("mean density", mean, "area fraction n/n_c averaged over the box"),
        Scale("grain diameter d/L_x", diameter, "K/mu"),
        Scale("1 - r^2", inelasticity(deck), f"for gamma = {gas.gamma:g}, mu = {gas.mu:g}"),
    ]
    if diameter > 0.0:
        grains = 2.0 / math.sqrt(3.0) * mean * deck.box.aspect_ratio / diameter**2
        knudsen = float(state.gas.mean_free_path(mean)) * diameter
        found += [
            Scale("grains", grains, "in the box"),
            Scale("Knudsen number", knudsen, "mean free path at the mean density over L_x"),
        ]
    return found


def _time_scales(deck: EvolutionDeck, state: State) -> list[Scale]:
    gas, mean = state.gas, mean_density(state)
    T = float(state.temperature.mean())
    found = [Scale("sound time", 1.0 / float(gas.sound_speed(mean, T)), "L_x over the sound speed at the start")]
    if gas.K > 0.0:
        conduction = mean / float(gas.conductivity(mean, T))
        found.append(Scale("conduction time", conduction, "n L_x^2/kappa at the start"))
    if gas.K * gas.L > 0.0:
        cooling = 2.0 * mean * T / float(gas.cooling(mean, T))
        found.append(Scale("cooling time", cooling, "t_c of T = T_0/(1 + t/t_c)^2 at the start"))
    found.append(Scale("friction time", deck.gas.tau, "tau"))
    if isinstance(deck.wall, Vibrating) and deck.wall.W > 0.0:
        found.append(Scale("wall temperature", driven_temperature(deck), "about, in states like that of Fig. 4"))
    return found


def _mesh_scales(deck: EvolutionDeck, state: State) -> list[Scale]:
    mesh = state.mesh
    steps, meaning = STEPS[deck.time.integrator](deck, state)
    cells, integrator = mesh.areas.size, deck.time.integrator
    return [
        Scale("narrowest cell in x", float(mesh.dx.min()), "at x = 0"),
        Scale("cell in y", float(mesh.dy.max()), ""),
        Scale("thermal length", thermal_length(state), f"over which conduction balances cooling at n = {DENSE}"),
        Scale("explicit time step", largest_step(deck, state), "at the start, by sound"),
        Scale("steps", steps, meaning),
        Scale("memory", cells * BYTES_PER_CELL[integrator] / 2**20, "MiB for state and work space"),
        Scale("run time", steps * cells * SECONDS_PER_CELL_STEP[integrator], "seconds, a guess for one core"),
    ]


def explicit_steps(deck: EvolutionDeck, state: State) -> tuple[float, str]:
    """How many steps sound asks for."""
    hotter = max(1.0, driven_temperature(deck) / float(state.temperature.max()))
    steps = deck.time.end / largest_step(deck, state) * math.sqrt(hotter)
    return steps, "about, with the sound speed of the start or of the driving wall"


def implicit_steps(deck: EvolutionDeck, state: State) -> tuple[float, str]:
    """How many steps the tolerance asks for."""
    return IMPLICIT_STEPS / math.sqrt(deck.time.tolerance), "as in Fig. 4 at this tolerance"


STEPS: dict[str, Callable[[EvolutionDeck, State], tuple[float, str]]] = {
    "godunov": explicit_steps,
    "lagrange-remap": implicit_steps,
}


def warnings(deck: EvolutionDeck, state: State) -> list[str]:
    """Where the assumptions behind the equations, or the mesh, are in doubt."""
    mach, width = initial_mach(state), max(float(state.mesh.dx.min()), float(state.mesh.dy.max()))
    length, elasticity = thermal_length(state), inelasticity(deck)
    verdicts = [
        (
            elasticity > NEARLY_ELASTIC,
            f"1 - r^2 = {elasticity:.3g} is not small: the closures hold for nearly elastic grains "
            f"(K/mu = {grain_diameter(deck):.3g} and L = {deck.gas.L:g} together fix it)",
        ),
        (
            elasticity > 1.0,
            "no grains have that: 1 - r^2 is at most 1. Take a smaller K or L, or a larger mu",
        ),
        (
            deck.gas.f is not None and not deck.initial.needs_area_fraction,
            f"gas.f is not used: the initial state has the mean density {mean_density(state):.4g}",
        ),
        (
            driven_temperature(deck) > 0.0 and width > length,
            f"cells of {width:.3g} are wider than the thermal length {length:.3g} of a cluster of density {DENSE}: "
            "its largest density will be off by several percent or more",
        ),
        (
            mach > FAST,
            f"the initial state drives flow of Mach {mach:.2g}: the paper's slow evolution at uniform pressure "
            "comes only after that has died",
        ),
        (
            float(state.density.max()) > CRYSTAL,
            f"n = {state.density.max():.3g} at the start: disks crystallize above {CRYSTAL}, the equation of state "
            "is an interpolation there",
        ),
    ]
    return [text for holds, text in verdicts if holds]


def driven_temperature(deck: EvolutionDeck) -> float:
    """Temperature of the driving wall, in states like those of Figs. 3 and 4; zero for an elastic wall."""
    if isinstance(deck.wall, Thermal):
        return deck.wall.temperature
    return deck.wall.W / PAPER_W if isinstance(deck.wall, Vibrating) else 0.0


def mean_density(state: State) -> float:
    """Average of n over the box."""
    return state.mass / state.mesh.aspect_ratio


def grain_diameter(deck: EvolutionDeck) -> float:
    """d/L_x = K/mu."""
    return deck.gas.K / deck.gas.mu


def inelasticity(deck: EvolutionDeck) -> float:
    """1 - r^2 = (3 gamma/32) L (d/L_x)^2, from the definition of L."""
    return 3.0 * deck.gas.gamma / 32.0 * deck.gas.L * grain_diameter(deck) ** 2


def thermal_length(state: State) -> float:
    """(kappa/(dI/dT))^(1/2) in a cluster: the shortest length of its density profile. Infinite without cooling."""
    conduction, cooling = state.gas.conductivity_coefficient(DENSE), state.gas.cooling_coefficient(DENSE)
    return math.sqrt(conduction / (1.5 * cooling)) if cooling > 0.0 else math.inf


def initial_mach(state: State) -> float:
    """Mach number of the flow at the start, or of that which its pressure differences will drive."""
    pressure = state.pressure
    driven = float(np.ptp(pressure) / (2.0 * np.min(pressure * state.gas.adiabatic_exponent(state.density))))
    return max(float(state.mach.max()), driven)


def largest_step(deck: EvolutionDeck, state: State) -> float:
    """The step that the CFL condition allows at the start; numpy's version of `signal_rates`."""
    mesh, c = state.mesh, state.gas.sound_speed(state.density, state.temperature)
    u, v = (np.abs(component) for component in state.velocity)
    rate = 2.0 * np.maximum((u + c) / mesh.dx[:, None], (v + c) / mesh.dy[None, :]).max()
    return min(deck.time.cfl / float(rate), deck.time.dt_max or math.inf, deck.time.end)
