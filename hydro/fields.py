"""Places of the fields of a gas in arrays (4, nx, ny)."""

N, MX, MY, E = 0, 1, 2, 3  # conserved: density, momentum along x and y, energy
U, V, P = 1, 2, 3  # in place of these, primitive: velocity along x and y, pressure
