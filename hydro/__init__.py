"""hydro: a laboratory of granular gases. Hydrodynamics, steady states, stability and the grains, from one deck."""

import importlib
from typing import Any

__version__ = "0.2.0"
HOMES = {
    "march": "hydro.driver.march",
    "open_run": "hydro.output.dataset",
    "open_sweep": "hydro.studies.sweep",
    "read_history": "hydro.output.dataset",
    "run": "hydro.kinds.run",
}

__all__ = list(HOMES)


def __getattr__(name: str) -> Any:
    """What users call, imported when they do: the command line must not wait for it."""
    if name not in HOMES:
        raise AttributeError(f"module 'hydro' has no attribute {name!r}")
    return getattr(importlib.import_module(HOMES[name]), name)


def __dir__() -> list[str]:
    return [*globals(), *__all__]
