"""A source that is given: rates of the four conserved fields as a function of time, for manufactured solutions."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hydro.accounts import SOURCE
from hydro.mesh import Mesh
from hydro.terms.term import Term


class Source(Term):
    """rates: a function of time and mesh that gives an array (4, nx, ny), scaled."""

    account = SOURCE

    def __init__(self, rates: Callable[[float, Mesh], np.ndarray]):
        self._rates = rates

    def rates(self, time: float, mesh: Mesh) -> np.ndarray:
        return self._rates(time, mesh)
