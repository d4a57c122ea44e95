"""hydro: time-dependent compressible granular hydrodynamics."""

import importlib
from typing import Any

__version__ = "0.2.0"
__all__ = ["open_run", "open_sweep", "read_history"]

HOMES = {
    "open_run": "hydro.output.dataset",
    "open_sweep": "hydro.studies.sweep",
    "read_history": "hydro.output.dataset",
}


def __getattr__(name: str) -> Any:
    """What users call, imported when they do: the command line must not wait for it."""
    if name not in HOMES:
        raise AttributeError(f"module 'hydro' has no attribute {name!r}")
    return getattr(importlib.import_module(HOMES[name]), name)
