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


HLLC_PLAIN, HLLC_LOW_MACH = HLLC(0.0), HLLC(0.3)
