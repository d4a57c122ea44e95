"""Terms of the equations beside flow and heat: a file each. They are imported when they are first used."""

from importlib import import_module
from typing import Any

HOMES = {
    "Friction": "hydro.terms.friction",
    "Source": "hydro.terms.source",
    "Stress": "hydro.terms.term",
    "Term": "hydro.terms.term",
    "Terms": "hydro.terms.together",
    "Viscosity": "hydro.terms.viscosity",
}

__all__ = list(HOMES)


def __getattr__(name: str) -> Any:
    """What the folder holds, without its kernels before they are needed."""
    if name not in HOMES:
        raise AttributeError(f"module 'hydro.terms' has no attribute {name!r}")
    return getattr(import_module(HOMES[name]), name)
