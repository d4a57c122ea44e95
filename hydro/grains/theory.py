"""What kinetic theory says of smooth hard disks. n is in n_c, the diameter in L_x; the mass of a grain is 1."""

from __future__ import annotations

import math

from hydro.grains.placement import CLOSE_PACKING


def cooling_mu(gamma):
    """The mu with which the paper's cooling, (mu/(gamma l)) (1-r^2) n T^(3/2), is that of dilute grains."""
    return gamma * math.sqrt(math.pi / 8.0)


def conduction_mu(conductivity):
    """The mu with which the dilute limit of a closure's conductivity, over K T^(1/2), is 2 (T/pi)^(1/2)/d."""
    return math.sqrt(3.0 / math.pi) / conductivity


def covered(n):
    """Share of the area that disks of density n cover."""
    return math.pi / 4.0 * CLOSE_PACKING * n


def contact_value(n):
    """Pair correlation at contact (Henderson, Mol. Phys. 30, 971, 1975)."""
    phi = covered(n)
    return (1.0 - 7.0 * phi / 16.0) / (1.0 - phi) ** 2


def compressibility(n):
    """Z = p/(n T) = 1 + 2 phi chi up to freezing (Henderson), in the form that is accurate to a percent."""
    phi = covered(n)
    return (1.0 + phi * phi / 8.0) / (1.0 - phi) ** 2


def collision_rate(n, T, diameter):
    """Collisions of one grain in unit time (Enskog): 2 pi^(1/2) n d chi T^(1/2), per T_*^(1/2)/L_x."""
    return 2.0 * math.sqrt(math.pi) * CLOSE_PACKING * n / diameter * contact_value(n) * math.sqrt(T)


def cooling_rate(n, T, diameter, restitution):
    """-(dT/dt)/T of grains that cool uniformly, nearly elastic: a collision costs (1-r^2) T."""
    return 0.5 * (1.0 - restitution**2) * collision_rate(n, T, diameter)
