"""What an evolution deck means physically: its scales, and where the assumptions behind the equations fail."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hydro.check.regime import FLUID, Grains, Place, regime, stripe_of
from hydro.choices import INTEGRATORS
from hydro.deck import EvolutionDeck
from hydro.dynamics.lagrange.sound import RESOLVED, Sound, foreseen_steps, resolving_step
from hydro.exact.cooling_modes import critical_wave_numbers
from hydro.initial import initial_state
from hydro.observables.cooling import cools_freely
from hydro.setup import elastic_below
from hydro.state import State

VISCOUS_BYTES = 216  # more, where the gas has viscosity

DENSE = 0.76  # largest density of the localized states of Figs. 3 and 4
FAST = 0.3  # Mach number above which flow is more than a correction


@dataclass(frozen=True)
class Scale:
    """One number that describes the problem."""

    name: str
    value: float
    meaning: str

    def __str__(self) -> str:
        return f"{self.name:<28} {self.value:<12.4g} {self.meaning}"


@np.errstate(all="ignore")  # scales may be beyond all numbers
def report(deck: EvolutionDeck) -> list[str]:
    """Lines on the scales of a deck, and its warnings. DeckError if its initial state is not legal."""
    state = initial_state(deck)
    lines = ["scales (units: L_x, n_c, T_*)", *map(str, scales(deck, state)), *regime(deck, [place_of(deck, state)])]
    return lines + [f"warning: {warning}" for warning in warnings(deck, state)]


def place_of(deck: EvolutionDeck, state: State) -> Place:
    """Where the extended state lies that has the mass of `state`."""
    return Place(deck.gas.L, mean_density(state), deck.box.aspect_ratio)


def scales(deck: EvolutionDeck, state: State) -> list[Scale]:
    """Scales of the deck's gas, walls, mesh and run from its initial state, in scaled units."""
    return [*_grain_scales(deck, state), *_time_scales(deck, state), *_mesh_scales(deck, state)]


def _grain_scales(deck: EvolutionDeck, state: State) -> list[Scale]:
    gas, grains, mean = deck.gas, Grains.of(deck), mean_density(state)
    diameter = grains.diameter
    found = [
        Scale("mean density", mean, "area fraction n/n_c averaged over the box"),
        Scale("grain diameter d/L_x", diameter, "K/mu"),
        Scale("1 - r^2", grains.inelasticity(gas.L), f"for gamma = {gas.gamma:g}, mu = {gas.mu:g}"),
    ]
    if diameter > 0.0:
        number = 2.0 / math.sqrt(3.0) * mean * deck.box.aspect_ratio / diameter**2
        knudsen = float(state.gas.mean_free_path(mean)) * diameter
        found += [
            Scale("grains", number, "in the box"),
            Scale("Knudsen number", knudsen, "mean free path at the mean density over L_x"),
        ]
    return found


def _time_scales(deck: EvolutionDeck, state: State) -> list[Scale]:
    gas, mean = state.gas, mean_density(state)
    T = float(state.temperature.mean())
    found = [Scale("sound time", 1.0 / float(gas.sound_speed(mean, T)), "L_x over the sound speed at the start")]
    if (kappa := float(gas.conductivity(mean, T))) > 0.0:
        conduction = mean / kappa
        found.append(Scale("conduction time", conduction, "n L_x^2/kappa at the start"))
    if (loss := float(gas.cooling(mean, T))) > 0.0:
        found.append(Scale("cooling time", 2.0 * mean * T / loss, "t_c of T = T_0/(1 + t/t_c)^2 at the start"))
    found.append(Scale("friction time", deck.gas.tau, "tau"))
    if cools_freely(deck):
        critical = critical_wave_numbers(gas, mean, deck.gas.viscosity)
        found += [
            Scale("critical length, shear", 2.0 * math.pi / critical["shear"], "shear layers longer than that grow"),
            Scale("critical length, clusters", over(2.0 * math.pi, critical["clusters"]), "longer clusters grow"),
        ]
    driven = driven_temperature(deck, state)
    if driven > 0.0:
        found.append(Scale("wall temperature", driven, "of the driving wall, in the extended state"))
    if (elastic := elastic_below(deck)) > 0.0:
        found.append(Scale("elastic below", elastic, "temperature below which collisions lose nothing"))
    return found


def _mesh_scales(deck: EvolutionDeck, state: State) -> list[Scale]:
    mesh = state.mesh
    integrator, cells = INTEGRATORS[deck.time.integrator], mesh.areas.size
    steps, meaning = integrator.expected_steps(deck, steps_by_sound(deck, state))
    bytes_per_cell = integrator.bytes_per_cell + (VISCOUS_BYTES if deck.gas.viscosity > 0.0 else 0)
    return [
        Scale("narrowest cell in x", float(mesh.dx.min()), "at x = 0"),
        Scale("cell in y", float(mesh.dy.max()), ""),
        Scale("thermal length", thermal_length(state), f"over which conduction balances cooling at n = {DENSE}"),
        Scale("explicit time step", largest_step(deck, state), "at the start, by sound"),
        Scale("steps", steps, meaning),
        Scale("memory", cells * bytes_per_cell / 2**20, "MiB for state and work space"),
        Scale("run time", steps * cells * integrator.seconds_per_cell_step, "seconds, a guess for one core"),
    ]


def steps_by_sound(deck: EvolutionDeck, state: State) -> float:
    """How many steps sound asks for."""
    driven = driven_temperature(deck, state)
    if driven == 0.0:
        return time_of_sound(deck, state) / largest_step(deck, state)
    hotter = max(1.0, driven / float(state.temperature.max()))
    return deck.time.end / largest_step(deck, state) * math.sqrt(hotter)


def time_of_sound(deck: EvolutionDeck, state: State) -> float:
    """How long sound of the speed at the start takes for what it does in the run, in a gas that cools by Haff's law."""
    n, T, gas = mean_density(state), float(state.temperature.mean()), state.gas
    rate = float(gas.cooling(n, T)) / (2.0 * n * T)  # one over the cooling time
    return math.log1p(rate * deck.time.end) / rate if rate > 0.0 else deck.time.end


def over(length: float, number: float) -> float:
    """A length over a number; infinite for zero."""
    return length / number if number > 0.0 else math.inf


def warnings(deck: EvolutionDeck, state: State) -> list[str]:
    """Where the assumptions behind the equations, or the mesh, are in doubt."""
    mach, width = initial_mach(state), max(float(state.mesh.dx.min()), float(state.mesh.dy.max()))
    length, sound = thermal_length(state), Sound.of(state)
    steps = sound_steps(deck, sound)
    verdicts = [
        (
            deck.gas.f is not None and not math.isclose(deck.gas.f, mean_density(state), rel_tol=1e-9),
            f"gas.f is not used: the initial state has the mean density {mean_density(state):.4g}",
        ),
        (
            driven_temperature(deck, state) > 0.0 and width > length,
            f"cells of {width:.3g} are wider than the thermal length {length:.3g} of a cluster of density {DENSE}: "
            "its largest density will be off by several percent or more",
        ),
        (
            mach > FAST,
            f"the initial state drives flow of Mach {mach:.2g}: the paper's slow evolution at uniform pressure "
            "comes only after that has died",
        ),
        (
            deck.time.integrator == "lagrange-remap" and sound.amplitude > 0.0 and steps < RESOLVED,
            f"sound is not resolved: its amplitude is {sound.amplitude:.2g} at the start, and time.tolerance = "
            f"{deck.time.tolerance:g} leaves about {steps:.1f} steps to a period of {sound.period:.3g} of the slowest, "
            f"where {RESOLVED:g} are needed; time.dt_max = {resolving_step(sound.period):.2g} follows it",
        ),
        (
            float(state.density.max()) > FLUID[0],
            f"n = {state.density.max():.3g} at the start: disks crystallize above {FLUID[0]}, the equation of state "
            "is an interpolation there",
        ),
    ]
    return [text for holds, text in verdicts if holds]


def sound_steps(deck: EvolutionDeck, sound: Sound) -> float:
    """Steps in a period of the slowest sound, as the tolerance and time.dt_max have them."""
    longest = deck.time.dt_max or math.inf
    return max(foreseen_steps(sound.amplitude, deck.time.tolerance), sound.period / longest)


def driven_temperature(deck: EvolutionDeck, state: State) -> float:
    """Temperature of the driving wall in the extended state of the same mass; zero where nothing is driven."""
    stripe = stripe_of(deck, place_of(deck, state))
    return 0.0 if stripe.state is None else stripe.wall_temperature


def mean_density(state: State) -> float:
    """Average of n over the box."""
    return state.mass / state.mesh.aspect_ratio


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
