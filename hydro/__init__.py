"""hydro: time-dependent compressible granular hydrodynamics."""

from typing import Any

__version__ = "0.1.0"
__all__ = ["open_run", "read_history"]


def __getattr__(name: str) -> Any:
    """What users call, imported when they do: the command line must not wait for it."""
    if name not in __all__:
        raise AttributeError(f"module 'hydro' has no attribute {name!r}")
    from hydro.runs import dataset

    return getattr(dataset, name)
