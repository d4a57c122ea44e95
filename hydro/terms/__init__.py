"""Terms of the equations beside flow and heat: a file each. They are imported when they are first used."""

from importlib import import_module
from typing import Any

__all__ = ["Friction", "Source", "Stress", "Term", "Terms", "Viscosity"]

HOMES = {
    "Friction": "hydro.terms.friction",
    "Source": "hydro.terms.source",
    "Stress": "hydro.terms.term",
    "Term": "hydro.terms.term",
    "Terms": "hydro.terms.together",
    "Viscosity": "hydro.terms.viscosity",
}


def __getattr__(name: str) -> Any:
    """What the folder holds, without its kernels before they are needed."""
    if name not in HOMES:
        raise AttributeError(f"module 'hydro.terms' has no attribute {name!r}")
    return getattr(import_module(HOMES[name]), name)
