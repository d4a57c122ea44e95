"""What decks choose from: a table for each choice, a line for each name.

Nothing is loaded here. A new closure, wall, integrator, initial state or kind of deck is a file of its own, and its
line in one of these tables: decks, messages and docs/decks.md take the names from here.
"""

from __future__ import annotations

from typing import Any

from hydro.registry import Entry, Registry

# What a gas is: `gas.closure`. The keys of its section are the fields of its NamedTuple.
CLOSURES: Registry[Any] = Registry(
    "closure", {"grossman": "hydro.gas.grossman:Grossman"}, asks="hydro.gas.closure:Closure", compiled=True
)

# What walls do, in decks that at x = 1: `wall.kind`. Each is a section that gives the law of the wall.
WALLS: Registry[Any] = Registry(
    "wall",
    {
        "vibrating": "hydro.walls.vibrating:Vibrating",
        "thermal": "hydro.walls.thermal:Thermal",
        "elastic": "hydro.walls.elastic:Elastic",
    },
    asks="hydro.walls.law:WallLaw",
    compiled=True,
)

# How grains meet them, and how one that vibrates moves: functions of the deck. `grains.drive`
GRAIN_WALLS: Registry[Any] = Registry(
    "driving wall of grains",
    {
        "vibrating": "hydro.grains.integrator:vibrating",
        "thermal": "hydro.grains.integrator:thermal",
        "elastic": "hydro.grains.integrator:elastic",
    },
)
DRIVES: Registry[Any] = Registry(
    "drive",
    {
        "random-phase": "hydro.grains.integrator:random_phase",
        "sinusoidal": "hydro.grains.integrator:sinusoidal",
        "sawtooth": "hydro.grains.integrator:sawtooth",
    },
)

# Where a run in time begins: `initial.kind`. Each is a section that gives the state.
INITIAL_STATES: Registry[Any] = Registry(
    "initial state",
    {
        "cosine": "hydro.initial.cosine:Cosine",
        "modes": "hydro.initial.modes:Modes",
        "noise": "hydro.initial.noise:Noise",
        "uniform": "hydro.initial.uniform:Uniform",
        "simple_wave": "hydro.initial.simple_wave:SimpleWave",
        "density_wave": "hydro.initial.density_wave:DensityWave",
        "eigenmode": "hydro.initial.eigenmode:Eigenmode",
        "manufactured": "hydro.initial.manufactured:Manufactured",
        "profile": "hydro.initial.profile:Profile",
        "riemann": "hydro.initial.riemann:Riemann",
        "checkpoint": "hydro.initial.checkpoint:FromCheckpoint",
    },
    asks="hydro.initial.state:InitialState",
)

# What changes a density that is there: `initial.perturbation.kind`, `sweep.perturbation.kind`.
PATTERNS: Registry[Any] = Registry(
    "pattern",
    {
        "cosine": "hydro.initial.cosine:CosinePattern",
        "modes": "hydro.initial.modes:ModesPattern",
        "noise": "hydro.initial.noise:NoisePattern",
    },
    asks="hydro.initial.state:Pattern",
)

# Terms of the equations beside flow and heat. Where a section stands beside a term, decks of evolutions have a section
# of its name.
TERMS: Registry[Any] = Registry(
    "term", {"friction": "hydro.terms.friction:Friction", "viscosity": "hydro.terms.viscosity:Viscosity"}
)

# How to step in time: `time.integrator`, `scheme.limiter`, `scheme.riemann`.
INTEGRATORS: Registry[Any] = Registry(
    "integrator",
    {
        "godunov": "hydro.dynamics.godunov:Godunov",
        "lagrange-remap": "hydro.dynamics.lagrange:LagrangeRemap",
    },
    asks="hydro.dynamics.integrator:Integrator",
)
LIMITERS: Registry[Any] = Registry(
    "limiter",
    {
        "minmod": "hydro.dynamics.limiters:MINMOD",
        "van_leer": "hydro.dynamics.limiters:VAN_LEER",
        "mc": "hydro.dynamics.limiters:MC",
    },
)
RIEMANN_SOLVERS: Registry[Any] = Registry(
    "Riemann solver", {"hllc": "hydro.dynamics.riemann:HLLC_PLAIN", "hllc_lm": "hydro.dynamics.riemann:HLLC_LOW_MACH"}
)

# Steady states: how to find one, `steady.search`; what a branch is followed in beside constants of the closure,
# `branch.parameter`; the walls that can drive one, and the condition that each sets at marginal stability.
SEARCHES: Registry[Any] = Registry(
    "search", {"relaxation": "hydro.steady.localized:relaxed", "branch": "hydro.steady.bifurcation:first_on_branch"}
)
PARAMETERS: Registry[Any] = Registry(
    "parameter",
    {
        "f": "hydro.steady.balance:with_area_fraction",
        "aspect_ratio": "hydro.steady.balance:with_aspect_ratio",
    },
)
WALL_CONDITIONS: Registry[Any] = Registry(
    "wall", {"vibrating": "hydro.steady.marginal:vibrating", "thermal": "hydro.steady.marginal:thermal"}
)

# What a study measures errors against: `convergence.reference`.
REFERENCES: Registry[Any] = Registry(
    "reference",
    {
        "exact": "hydro.studies.references:exact",
        "finest": "hydro.studies.references:finest",
        "next": "hydro.studies.references:following",
    },
)

# What is measured of states, for the problem that a deck poses: the last of those that fit.
OBSERVABLES: Registry[Any] = Registry(
    "set of observables",
    {
        "clustering": "hydro.observables.clustering:CLUSTERING",
        "cooling": "hydro.observables.cooling:COOLING",
    },
)

# Pictures of the states of a run that a set of observables has beside maps and profiles.
STATE_PICTURES: Registry[Any] = Registry(
    "picture",
    {
        "structure": "hydro.pictures.structure:structure_factors",
        "vorticity": "hydro.pictures.vorticity:vorticity_panels",
    },
)

# How densities are drawn, `movie.scale`, and grains, `output.colour`.
SCALES: Registry[Any] = Registry("scale", {"linear": "matplotlib.colors:Normalize", "log": "matplotlib.colors:LogNorm"})
GRAIN_COLOURS: Registry[Any] = Registry(
    "colour", {"speed": "hydro.pictures.grains:by_speed", "cluster": "hydro.pictures.grains:by_cluster"}
)

# What a deck asks for: `kind`. What is done, and the model of the deck.
KINDS: Registry[Any] = Registry(
    "kind",
    {
        "evolution": Entry("hydro.kinds.evolution:KIND", section="hydro.deck.evolution:EvolutionDeck"),
        "steady": Entry("hydro.kinds.steady:KIND", section="hydro.deck.steady:SteadyDeck"),
        "branch": Entry("hydro.kinds.branch:KIND", section="hydro.deck.steady:BranchDeck"),
        "stability": Entry("hydro.kinds.stability:KIND", section="hydro.deck.stability:StabilityDeck"),
        "grains": Entry("hydro.kinds.grains:KIND", section="hydro.deck.grains:GrainsDeck"),
        "convergence": Entry("hydro.studies.convergence:KIND", section="hydro.deck.studies:ConvergenceDeck"),
        "sweep": Entry("hydro.studies.sweep:KIND", section="hydro.deck.studies:SweepDeck"),
    },
)
