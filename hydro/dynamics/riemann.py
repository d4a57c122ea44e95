"""Approximate Riemann solvers for a general equation of state."""

from __future__ import annotations

from typing import NamedTuple

from hydro.methods import compiled_methods

LARGE_JUMP = 0.01  # of the pressure, relative; slow flow makes much smaller ones


@compiled_methods
class HLLC(NamedTuple):
    """HLLC (Toro, Spruce and Speares, Shock Waves 4, 25, 1994) with Davis's wave speeds.

    Below the Mach number `mach_limit` the jump of velocity across the face shrinks in proportion to the Mach
    number (Thornber et al., J. Comput. Phys. 227, 4873, 2008): its acoustic dissipation, of order rho c du,
    otherwise swamps the pressure differences, of order rho u^2, that drive a slow flow. It never shrinks below
    what a sound wave with this jump of pressure has, dp/(rho c): sound, slow or not, is upwinded as in plain
    HLLC; and not at all where the pressure jumps by a percent, so that shocks do not ring in slow gas. Zero means
    plain HLLC.
    """

    mach_limit: float

    def flux(self, gas, n_l, u_l, v_l, p_l, n_r, u_r, v_r, p_r):
        """Flux of (mass, normal momentum, transverse momentum, energy) between a left and a right state.

        States are density, normal and transverse velocity, and pressure. With equal pressures and no
        velocities only momentum crosses; between mirror images of each other likewise.
        """
        c_l = gas.sound_speed_at_pressure(n_l, p_l)
        c_r = gas.sound_speed_at_pressure(n_r, p_r)
        mean = 0.5 * (u_l + u_r)
        half_jump = 0.5 * (u_r - u_l)
        mach = max(abs(u_l), abs(u_r)) / min(c_l, c_r)
        sound = abs(p_r - p_l) / (n_l * c_l + n_r * c_r)
        least = max(mach / self.mach_limit, abs(p_r - p_l) / (LARGE_JUMP * min(p_l, p_r)))
        size = min(abs(half_jump), max(abs(half_jump) * least, sound))
        slow = size if half_jump >= 0.0 else -size
        half_jump = slow if mach < self.mach_limit else half_jump
        u_l = mean - half_jump
        u_r = mean + half_jump

        s_l = min(u_l - c_l, u_r - c_r)
        s_r = max(u_l + c_l, u_r + c_r)
        mass_l = n_l * (s_l - u_l)
        mass_r = n_r * (s_r - u_r)
        s_star = (p_r - p_l + (mass_l * u_l - mass_r * u_r)) / (mass_l - mass_r)
        p_star = 0.5 * (p_l + p_r + mass_l * (s_star - u_l) + mass_r * (s_star - u_r))

        left = s_star >= 0.0
        n = n_l if left else n_r
        u = u_l if left else u_r
        v = v_l if left else v_r
        p = p_l if left else p_r
        s = s_l if left else s_r
        e = p / gas.compressibility(n) + 0.5 * n * (u * u + v * v)
        supersonic = s_l >= 0.0 or s_r <= 0.0
        inverse = 1.0 / (s - s_star)
        n_face = n if supersonic else n * (s - u) * inverse
        e_face = e if supersonic else (e * (s - u) - p * u + p_star * s_star) * inverse
        u_face = u if supersonic else s_star
        p_face = p if supersonic else p_star
        mass = n_face * u_face
        return mass, mass * u_face + p_face, mass * v, (e_face + p_face) * u_face


@compiled_methods
class Positive(NamedTuple):
    """The HLL flux with waves so fast that the state between them is admissible whenever both beside it are.

    Its density and internal energy are sums of n S and e_i S of both sides and of the work of p, all positive for waves
    with speeds S of sound or more beside the gas (Batten et al., SIAM J. Sci. Comput. 18, 1553, 1997). It stays below
    the density of packing if (1 - n_l/n_p) S_l + (1 - n_r/n_p) S_r exceeds the velocity with which both sides approach:
    the share of each in that velocity, over its 1 - n/n_p, is added to S. A shock that packs the gas is as fast.

    share: of each side.
    """

    share: float = 0.5

    def flux(self, gas, n_l, u_l, v_l, p_l, n_r, u_r, v_r, p_r):
        """As `HLLC.flux`."""
        approach = self.share * max(u_l - u_r, 0.0)
        s_l = min(u_l - gas.sound_speed_at_pressure(n_l, p_l) - approach / gas.gap(n_l), 0.0)
        s_r = max(u_r + gas.sound_speed_at_pressure(n_r, p_r) + approach / gas.gap(n_r), 0.0)
        e_l = p_l / gas.compressibility(n_l) + 0.5 * n_l * (u_l * u_l + v_l * v_l)
        e_r = p_r / gas.compressibility(n_r) + 0.5 * n_r * (u_r * u_r + v_r * v_r)
        over = 1.0 / (s_r - s_l)
        to_right, to_left = s_r * over, -s_l * over  # shares of the left and of the right flux
        mixing = s_l * to_right
        mass_l, mass_r = n_l * u_l, n_r * u_r
        return (
            to_right * mass_l + to_left * mass_r + mixing * (n_r - n_l),
            to_right * (mass_l * u_l + p_l) + to_left * (mass_r * u_r + p_r) + mixing * (mass_r - mass_l),
            to_right * mass_l * v_l + to_left * mass_r * v_r + mixing * (n_r * v_r - n_l * v_l),
            to_right * (e_l + p_l) * u_l + to_left * (e_r + p_r) * u_r + mixing * (e_r - e_l),
        )


HLLC_PLAIN, HLLC_LOW_MACH, POSITIVE = HLLC(0.0), HLLC(0.3), Positive()
