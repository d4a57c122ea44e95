"""Newton's method and continuation on a problem that is no gas: they ask a `Problem`, and nothing else."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pytest
from scipy import sparse

from hydro.errors import RunFailed
from hydro.steady.continuation import Family, Point, fold_between, follow
from hydro.steady.newton import relax, solve
from hydro.steady.problem import NotConverged, Slopes

CELLS = 63
FOLD = 3.513830719  # of -u'' = rate exp(u), u(0) = u(1) = 0 (Gelfand and Bratu)


@dataclass(frozen=True)
class Bratu:
    """-u'' = rate exp(u) at the points inside (0, 1); coupled to all is their mean, for its own sake."""

    rate: float
    highest: float = math.inf
    place = "a line"

    @property
    def laplacian(self):
        ones = np.ones(CELLS)
        return sparse.diags_array([ones[1:], -2.0 * ones, ones[1:]], offsets=[-1, 0, 1]) * (CELLS + 1) ** 2

    def residual(self, u):
        return np.append(self.laplacian @ u[:-1] + self.rate * np.exp(u[:-1]), u[:-1].mean() - u[-1])

    def slopes(self, u):
        matrix = (self.laplacian + sparse.diags_array(self.rate * np.exp(u[:-1]))).tocsc()
        return Slopes(matrix, np.zeros((CELLS, 1)), np.full((1, CELLS), 1.0 / CELLS), -np.ones((1, 1)))

    def scale(self, u):
        return np.ones(CELLS + 1)

    def round_off(self, u):
        return np.full(CELLS + 1, 1e-11)

    def capacity(self, u):
        return np.ones(CELLS)

    def refuse(self, u):
        if u.max() > self.highest:
            raise NotConverged("too high, for this test")

    def parameters(self):
        return ("rate",)

    def with_parameter(self, name, value):
        return replace(self, **{name: value})

    @property
    def weights(self):
        return np.append(np.full(CELLS, 1.0 / CELLS), 0.0)

    def amplitude(self, u):
        return u.max()

    def obstacle(self, u):
        return "reaches the ceiling" if u.max() > self.highest else ""


def test_newtons_method_and_relaxation_find_the_same_state():
    start = np.zeros(CELLS + 1)
    found = solve(Bratu(1.0), start).unknowns
    assert found[:-1].max() == pytest.approx(0.14054, rel=1e-3)
    assert found[-1] == pytest.approx(found[:-1].mean(), rel=1e-12)
    assert relax(Bratu(1.0), start) == pytest.approx(found, abs=1e-3)
    with pytest.raises(NotConverged, match="Newton iterations on a line"):
        solve(Bratu(4.0), start)
    with pytest.raises(NotConverged, match="too high"):
        solve(Bratu(1.0, highest=-1.0), start)


def branch(problem):
    family = Family(problem, "rate")
    vector = np.append(solve(family.at(0.0), np.zeros(CELLS + 1)).unknowns, 0.0)
    tangent = family.tangent(vector, np.append(np.zeros(CELLS + 1), 1.0))
    return family, follow(family, Point(vector, tangent), (0.5, 10.0), 0.5)


def test_a_branch_turns_at_its_fold():
    family, points = branch(Bratu(1.0))
    folds = [found for pair in pairwise(points) if (found := fold_between(family, *pair)) is not None]
    assert [fold.value for fold in folds] == pytest.approx([FOLD], rel=1e-3)
    assert family.amplitude(folds[0].vector) == pytest.approx(1.187, rel=1e-2)


def test_a_branch_ends_where_the_problem_says_so():
    _, points = branch(Bratu(1.0, highest=1.0))
    with pytest.raises(RunFailed, match=r"the branch reaches the ceiling at rate = 3\.\d+"):
        list(points)
