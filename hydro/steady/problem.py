"""What the methods of this folder ask of a steady problem: Newton's method, relaxation and continuation know no more.

Unknowns stand in one vector u of shape (N + k,): N that are coupled to few others, those of cells, then k that are
coupled to all, such as a pressure. So do residuals.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol, Self

import numpy as np
from scipy import sparse

from hydro.errors import RunFailed


class NotConverged(RunFailed):
    """No steady state is found from a start; says how far the search got."""


class Slopes(NamedTuple):
    """Derivatives of the residuals: [[matrix, columns], [rows, corner]]."""

    matrix: sparse.csc_array  # (N, N)
    columns: np.ndarray  # (N, k)
    rows: np.ndarray  # (k, N)
    corner: np.ndarray  # (k, k)


class Problem(Protocol):
    """A steady problem; `hydro.steady.balance` is one."""

    def residual(self, u: np.ndarray) -> np.ndarray:
        """What is zero in a steady state, (N + k,)."""

    def slopes(self, u: np.ndarray) -> Slopes:
        """Its derivatives."""

    def scale(self, u: np.ndarray) -> np.ndarray:
        """What residuals are small against, (N + k,)."""

    def round_off(self, u: np.ndarray) -> np.ndarray:
        """What residuals cannot fall below, (N + k,)."""

    def capacity(self, u: np.ndarray) -> np.ndarray:
        """By how much the residuals must change the first N unknowns in unit time, when the gas relaxes, (N,)."""

    def refuse(self, u: np.ndarray) -> None:
        """NotConverged where the unknowns are beyond what the problem can be solved for."""

    @property
    def place(self) -> str:
        """Where it is solved, in words: "64 x 64 cells"."""

    # What continuation asks beside.

    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters that a branch may be followed in; their values are positive."""

    def with_parameter(self, name: str, value: float) -> Self:
        """The same problem for another value of a parameter."""

    @property
    def weights(self) -> np.ndarray:
        """Of the squares of changes of the unknowns, in the length of a change, (N + k,)."""

    def amplitude(self, u: np.ndarray) -> float:
        """How far a state is from those without the broken symmetry that the branch leaves."""

    def obstacle(self, u: np.ndarray) -> str:
        """Why a branch cannot go on from here, "reaches ..."; empty where it can."""
