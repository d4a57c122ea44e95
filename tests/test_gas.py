"""Closures, and functions of them in kernels."""

from __future__ import annotations

import numpy as np

from hydro.gas import Grossman
from hydro.jit import kernel


@kernel
def compiled_properties(gas, n, T, out):
    for k in range(n.size):
        out[0, k] = gas.pressure(n[k], T)
        out[1, k] = gas.sound_speed(n[k], T)
        out[2, k] = gas.conductivity(n[k], T)
        out[3, k] = gas.cooling(n[k], T)
        out[4, k] = gas.density(out[0, k], T)
        out[5, k], out[6, k] = gas.viscosities(n[k], T)


def test_closures_are_the_same_in_numpy_and_in_kernels():
    gas, n, T = Grossman(5e4, 2e-3), np.geomspace(1e-4, 0.999, 50), 0.37
    out = np.zeros((7, 50))
    compiled_properties(gas, n, T, out)
    p = gas.pressure(n, T)
    expected = [p, gas.sound_speed(n, T), gas.conductivity(n, T), gas.cooling(n, T), gas.density(p, T)]
    np.testing.assert_allclose(out[:5], expected, rtol=1e-13)
    assert np.all(np.abs(out[5:] - gas.viscosities(n, T)) <= 1e-13 * gas.conductivity(n, T))
