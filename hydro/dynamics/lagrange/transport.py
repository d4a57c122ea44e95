"""What the faces sweep over in a step, and the momentum that streams with it."""

from __future__ import annotations

import numpy as np

from hydro.dynamics.lagrange.rows import add_difference, add_row
from hydro.dynamics.lagrange.workspace import DENSITY_HIGH, DENSITY_LOW, ENERGY, MASS, PADDED, PROFILES, STREAMS, WEIGHT
from hydro.fields import MX, MY, N
from hydro.jit import kernel, part
from hydro.mesh import GHOSTS

ONE, TWO = np.uint64(1), np.uint64(2)


@kernel(exact=True)
def sweep_rate(velocity, dx, dy):
    """The largest share of a cell that a face sweeps per time; velocity: `Faces`."""
    nx, ny = dx.size, dy.size
    largest = 0.0
    for i in range(nx + 1):
        for j in range(ny):
            largest = max(largest, abs(velocity.x[i, j]) / min(dx[i % nx], dx[i - 1]))
    for i in range(nx):
        for j in range(ny + 1):
            largest = max(largest, abs(velocity.y[i, j]) / min(dy[j % ny], dy[j - 1]))
    return largest


@kernel(exact=True)
def face_momenta(geometry, state, momentum):
    """Mean momenta of the two cells of every face, into `momentum`; zero where a face is closed."""
    nx, ny = state.shape[1:]
    for i in range(nx + 1):
        aperture = geometry.aperture_x[geometry.pattern_x[i]]
        for j in range(ny):
            momentum.x[i, j] = aperture[j] * (0.5 * (state[MX, i % nx, j] + state[MX, i - 1, j]))
    for i in range(nx):
        aperture = geometry.aperture_y[geometry.pattern_y[i]]
        for j in range(ny + 1):
            momentum.y[i, j] = aperture[j] * (0.5 * (state[MY, i, j % ny] + state[MY, i, j - 1]))


@kernel(exact=True)
def carry(gas, limiter, geometry, now, before, ratio, h, velocity, work):
    """Swept profiles at the faces, and momentum of faces before pressure acts, into `work`.

    now, before: momenta of the faces at the last two states. velocity: of the faces, extrapolated, is set.
    """
    nx = work.stream.shape[1]
    weight = ratio * ratio / (1.0 + 2.0 * ratio)
    work.stream[:] = 0.0
    for i in range(nx + 1):
        add_difference(now.x[i], before.x[i], ratio, velocity.x[i])
        divide_row(velocity.x[i], work.ahead[N, i + GHOSTS - 1], work.ahead[N, i + GHOSTS])
        carry_across(gas, limiter, geometry, velocity.x[i], h, work, i)
    for i in range(nx):
        add_difference(now.y[i], before.y[i], ratio, velocity.y[i])
        divide_line(velocity.y[i], work.ahead[N, i + GHOSTS])
        carry_along(gas, limiter, geometry, velocity.y[i], h, work, i)
    for i in range(nx + 1):
        momentum_across(geometry, now.x[i], before.x[i], weight, work, i)
    for i in range(nx):
        momentum_along(geometry, now.y[i], before.y[i], weight, work, i)


@part(exact=True)
def divide_row(momentum, density_low, density_high):
    """Velocities of faces in x, in place of their momenta."""
    for j in range(np.uint64(momentum.size)):
        momentum[j] *= 2.0 / (density_low[j] + density_high[j])


@part(exact=True)
def divide_line(momentum, density):
    """Velocities of faces in y, in place of their momenta."""
    ny = density.size
    for j in range(ONE, np.uint64(ny)):
        momentum[j] *= 2.0 / (density[j] + density[j - ONE])
    momentum[0] *= 2.0 / (density[0] + density[-1])
    momentum[ny] *= 2.0 / (density[0] + density[-1])


@part(exact=True)
def carry_across(gas, limiter, geometry, velocity, h, work, i):
    """The faces in x below row i."""
    ahead, lines, spacing = work.ahead, work.lines, geometry.spacing_x
    nx, ny = work.stream.shape[1:]
    here = i + GHOSTS
    upstream_row(velocity, lines[WEIGHT])
    for q in range(4):
        profile_row(limiter, ahead[q], here, spacing, lines[WEIGHT], lines[PROFILES + q])
    mass, energy = work.carried_x[MASS, i], work.carried_x[ENERGY, i]
    carry_row(gas, ahead[N, here - 1], ahead[N, here], velocity, lines, mass, energy)
    scale = geometry.scale_x[i]
    for j in range(np.uint64(ny)):
        length = scale * geometry.dy[j]
        mass[j] *= length
        energy[j] *= length
    for q in range(2):
        if i > 0:
            add_row(
                work.stream[q, i - 1], lines[STREAMS + q], -h * scale / (geometry.scale[i - 1] * geometry.dx[i - 1])
            )
        if i < nx:
            add_row(work.stream[q, i], lines[STREAMS + q], h * scale / (geometry.scale[i] * geometry.dx[i]))


@part(exact=True)
def carry_along(gas, limiter, geometry, velocity, h, work, i):
    """The faces in y of row i."""
    lines, spacing = work.lines, geometry.spacing_y
    ny = work.stream.shape[2]
    upstream_row(velocity, lines[WEIGHT])
    for q in range(4):
        padded = lines[PADDED]
        pad_row(work.ahead[q, i + GHOSTS], geometry.periodic_y, padded)
        profile_line(limiter, padded, spacing[1], spacing[2], lines[WEIGHT], lines[PROFILES + q])
        if q == N:
            for j in range(np.uint64(ny + 1)):
                lines[DENSITY_LOW, j], lines[DENSITY_HIGH, j] = padded[j + ONE], padded[j + TWO]
    mass, energy = work.carried_y[MASS, i], work.carried_y[ENERGY, i]
    carry_row(gas, lines[DENSITY_LOW], lines[DENSITY_HIGH], velocity, lines, mass, energy)
    width = geometry.dx[i]
    for j in range(np.uint64(ny + 1)):
        mass[j] *= width
        energy[j] *= width
    for q in range(2):
        stream, momentum = lines[STREAMS + q], work.stream[q, i]
        for j in range(np.uint64(ny)):
            momentum[j] -= h / (geometry.scale[i] * geometry.dy[j]) * (stream[j + ONE] - stream[j])


@part(exact=True)
def pad_row(row, periodic, padded):
    """A row (ny,) and what lies beyond its ends, into (ny + 2 GHOSTS,): it is flat beyond walls."""
    ny = row.size
    for j in range(np.uint64(ny)):
        padded[j + TWO] = row[j]
    for ghost in range(GHOSTS):
        padded[1 - ghost] = row[ny - 1 - ghost] if periodic else row[0]
        padded[ny + GHOSTS + ghost] = row[ghost] if periodic else row[ny - 1]


@part(exact=True)
def upstream_row(velocity, weight):
    """The share of the lower side in what the faces sweep: half where nothing moves, so that mirror images stay so."""
    for j in range(np.uint64(velocity.size)):
        weight[j] = 1.0 if velocity[j] > 0.0 else (0.5 if velocity[j] == 0.0 else 0.0)


@part(exact=True)
def profile_row(limiter, field, here, spacing, weight, out):
    """Limited profiles of a field (nx + 2 GHOSTS, ny) at the faces in x below row `here`."""
    f0, f1, f2, f3 = field[here - 2], field[here - 1], field[here], field[here + 1]
    low1, high1, low2, high2 = spacing[1, here - 1], spacing[2, here - 1], spacing[1, here], spacing[2, here]
    for j in range(np.uint64(f0.size)):
        step = f2[j] - f1[j]
        below = f1[j] + 0.5 * limiter.limited((f1[j] - f0[j]) * low1, step * high1)
        above = f2[j] - 0.5 * limiter.limited(step * low2, (f3[j] - f2[j]) * high2)
        out[j] = weight[j] * below + (1.0 - weight[j]) * above


@part(exact=True)
def profile_line(limiter, padded, low, high, weight, out):
    """Limited profiles at the faces below the cells of a padded line and above the last, (ny + 4,)."""
    for j in range(np.uint64(padded.size - 3)):
        a, b = padded[j + ONE], padded[j + TWO]
        step = b - a
        below = a + 0.5 * limiter.limited((a - padded[j]) * low[j + ONE], step * high[j + ONE])
        above = b - 0.5 * limiter.limited(step * low[j + TWO], (padded[j + TWO + ONE] - b) * high[j + TWO])
        out[j] = weight[j] * below + (1.0 - weight[j]) * above


@part(exact=True)
def carry_row(gas, density_low, density_high, velocity, lines, mass, energy):
    """What a unit of momentum at the faces carries along per length, and the momentum streaming through them."""
    n_row, u_row, v_row, p_row = lines[PROFILES], lines[PROFILES + 1], lines[PROFILES + 2], lines[PROFILES + 3]
    stream_x, stream_y = lines[STREAMS], lines[STREAMS + 1]
    for j in range(np.uint64(velocity.size)):
        n, u, v, p = n_row[j], u_row[j], v_row[j], p_row[j]
        over = 2.0 / (density_low[j] + density_high[j])
        mass[j] = n * over
        energy[j] = (p / gas.compressibility(n) + p + 0.5 * n * (u * u + v * v)) * over
        stream_x[j], stream_y[j] = n * velocity[j] * u, n * velocity[j] * v


@part(exact=True)
def momentum_across(geometry, now, before, weight, work, i):
    """Momentum of the faces in x below row i from that of the last two states, and what streams into its cells."""
    momentum, stream = work.momentum.x[i], work.stream[0]
    here, behind, aperture = i % stream.shape[0], i - 1, geometry.aperture_x[geometry.pattern_x[i]]
    add_difference(now, before, weight, momentum)
    add_row(momentum, stream[behind], 0.5)
    add_row(momentum, stream[here], 0.5)
    for j in range(np.uint64(momentum.size)):
        momentum[j] *= aperture[j]


@part(exact=True)
def momentum_along(geometry, now, before, weight, work, i):
    """The same for the faces in y of row i."""
    momentum, stream, aperture = work.momentum.y[i], work.stream[1, i], geometry.aperture_y[geometry.pattern_y[i]]
    ny = stream.size
    add_difference(now, before, weight, momentum)
    for j in range(ONE, np.uint64(ny)):
        momentum[j] = aperture[j] * (momentum[j] + 0.5 * (stream[j] + stream[j - ONE]))
    for j in (0, ny):
        momentum[j] = aperture[j] * (momentum[j] + 0.5 * (stream[0] + stream[ny - 1]))
