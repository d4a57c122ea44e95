"""What is measured of a state, in named sets: one for each problem, chosen by what a deck has."""

from hydro.observables.clustering import CLUSTERING
from hydro.observables.sets import Observables, observables_in, observables_of

__all__ = ["CLUSTERING", "Observables", "observables_in", "observables_of"]
