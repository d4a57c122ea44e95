"""Terms of the equations beside flow and heat: a file each."""

from hydro.terms.friction import Friction
from hydro.terms.source import Source
from hydro.terms.term import Stress, Term
from hydro.terms.together import Terms
from hydro.terms.viscosity import Viscosity

__all__ = ["TERMS", "Friction", "Source", "Stress", "Term", "Terms", "Viscosity"]

TERMS = (Friction, Viscosity)  # those that decks name, each by `of`
