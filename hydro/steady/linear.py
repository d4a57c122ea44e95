"""Sparse linear systems with a few dense rows and columns at their border."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from hydro.errors import RunFailed

REFINEMENTS = 2


class Singular(RunFailed):
    """A matrix has no inverse, as far as its digits tell."""

    def __init__(self, problem: Exception):
        super().__init__(f"a system of linear equations cannot be solved: {str(problem).lower()}")


def factorized(matrix: sparse.csc_array):
    """LU factors of a matrix of symmetric pattern; Singular where a pivot is zero."""
    try:
        return splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.1, options={"SymmetricMode": True})
    except RuntimeError as error:
        raise Singular(error) from None


class Bordered:
    """Solves [[A, C], [R, D]] (x, y) = (f, g), by block elimination with refinement.

    A: sparse (N, N). columns C: (N, k), rows R: (k, N), corner D: (k, k). The bordered matrix may be regular where A is
    nearly singular; refinement restores the digits which elimination loses there.
    """

    def __init__(self, matrix: sparse.csc_array, columns: np.ndarray, rows: np.ndarray, corner: np.ndarray):
        self.matrix, self.columns, self.rows, self.corner = matrix, columns, rows, corner
        self._factors = factorized(matrix)
        self._through = self._factors.solve(columns)
        self._schur = corner - rows @ self._through

    def solve(self, right: np.ndarray) -> np.ndarray:
        """The solution for a right-hand side (N + k,)."""
        solution = self._eliminated(right)
        for _ in range(REFINEMENTS):
            solution += self._eliminated(right - self.times(solution))
        return solution

    def times(self, vector: np.ndarray) -> np.ndarray:
        """The bordered matrix times a vector (N + k,)."""
        inner, border = np.split(vector, [self.matrix.shape[0]])
        return np.concatenate([self.matrix @ inner + self.columns @ border, self.rows @ inner + self.corner @ border])

    def _border(self, right: np.ndarray) -> np.ndarray:
        try:
            return np.linalg.solve(self._schur, right)
        except np.linalg.LinAlgError as error:
            raise Singular(error) from None

    def _eliminated(self, right: np.ndarray) -> np.ndarray:
        inner, border = np.split(right, [self.matrix.shape[0]])
        start = self._factors.solve(inner)
        end = self._border(border - self.rows @ start)
        return np.concatenate([start - self._through @ end, end])
