"""Super-time-stepping: how many stages a step takes, and their coefficients.

RKL2 (Meyer, Balsara and Aslam, J. Comput. Phys. 257, 594, 2014) is a second-order Runge-Kutta method whose s stages
reach (s^2+s-2)/4 explicit steps. Stage j makes of the values y and their rates r, in a step dt,

    y_j = mu y_(j-1) + nu y_(j-2) + (1 - mu - nu) y_0 + dt (rate r_(j-1) + start_rate r_0);

the first one is y_1 = y_0 + dt first_rate(s) r_0.
"""

from __future__ import annotations

import math

from hydro.methods import formula

MOST_EXPLICIT_STEPS = 2e5  # that one step may reach


@formula
def stage_count(explicit_steps):
    """The smallest odd number of stages, three or more, that reaches so many explicit steps."""
    enough = math.ceil(0.5 * (math.sqrt(9.0 + 16.0 * min(explicit_steps, MOST_EXPLICIT_STEPS)) - 1.0))
    return max(3, enough + 1 - enough % 2)


@formula
def first_rate(count):
    """The weight of the first rate in the first of so many stages."""
    return 4.0 / (count * count + count - 2.0) / 3.0


@formula
def stage_weights(j, count):
    """mu, nu, rate and start_rate of stage j, the second or a later one of so many."""
    mu = (2.0 * j - 1.0) / j * _weight(j) / _weight(j - 1)
    nu = -(j - 1.0) / j * _weight(j) / _weight(j - 2)
    rate = mu * 3.0 * first_rate(count)
    return mu, nu, rate, (_weight(j - 1) - 1.0) * rate


@formula
def _weight(j):
    """b_j of the paper."""
    return 1.0 / 3.0 if j < 2 else (j * j + j - 2.0) / (2.0 * j * (j + 1.0))
