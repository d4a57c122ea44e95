"""Spectral elements on a line: nodes, derivatives and integrals within one element of -1 < r < 1."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import legendre


@dataclass(frozen=True)
class ReferenceElement:
    """A polynomial of degree N by its values at the N+1 Gauss-Lobatto nodes of -1 <= r <= 1."""

    nodes: np.ndarray  # (N+1,)
    weights: np.ndarray  # (N+1,), of the quadrature that is exact up to degree 2N-1
    derivative: np.ndarray  # (N+1, N+1), values -> values of d/dr
    integral: np.ndarray  # (N+1, N+1), values -> integrals from -1 to the nodes
    modes: np.ndarray  # (N+1, N+1), values -> Legendre coefficients

    @property
    def degree(self) -> int:
        return len(self.nodes) - 1


@cache
def reference_element(degree: int) -> ReferenceElement:
    """The element of the given degree, 2 or more."""
    top = legendre.Legendre.basis(degree)
    nodes = np.concatenate([[-1.0], np.sort(top.deriv().roots().real), [1.0]])
    values = legendre.legvander(nodes, degree)
    modes = np.linalg.inv(values)
    slopes = np.stack([legendre.Legendre.basis(k).deriv()(nodes) for k in range(degree + 1)], axis=1)
    areas = np.stack([legendre.Legendre.basis(k).integ(lbnd=-1)(nodes) for k in range(degree + 1)], axis=1)
    derivative = slopes @ modes
    derivative -= np.diag(derivative.sum(axis=1))  # a constant has no slope, to the last digit
    weights = 2.0 / (degree * (degree + 1) * top(nodes) ** 2)
    return ReferenceElement(nodes, weights, derivative, areas @ modes, modes)


def evaluate(coefficients: np.ndarray, r: np.ndarray) -> np.ndarray:
    """Legendre series, one for each point: coefficients (points, N+1), r (points,)."""
    return np.einsum("pk,pk->p", legendre.legvander(r, coefficients.shape[1] - 1), coefficients)
