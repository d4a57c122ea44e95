"""Grains that hardly touch lose nothing: the restitution of real grains tends to one at small speeds of impact.

Below a temperature T_e cooling dies out: it is multiplied by

    share(T) = T^4/(T^4 + T_e^4),

which is one, to the last bit, above 1e4 T_e. Without it a core that is pressed together cools to temperatures, and to
gaps between grains of 1 - n/n_p ~ T/p, that numbers cannot tell from zero. Disks have it in another form: their
`contact_time` t_c makes collisions elastic that follow within t_c. In packed gas at the pressure p most of them do
below a temperature of about (p t_c)^2. Scaled units; numbers or arrays.
"""

from __future__ import annotations

from hydro.methods import formula

ELASTIC_BELOW = 1e-8  # T_e before a heated wall if a deck has none: grains 1e-4 times as fast as beside it


@formula
def inelastic_share(T, elastic_below):
    """What cooling is multiplied by."""
    fourth = (T * T) * (T * T)
    square = elastic_below * elastic_below
    return fourth / (fourth + square * square)


@formula
def inelastic_share_slope(T, elastic_below):
    """Its derivative in T."""
    share = inelastic_share(T, elastic_below)
    return 4.0 * share * (1.0 - share) / T
