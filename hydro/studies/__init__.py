"""Studies made of many runs of a base deck: convergence on a ladder of grids and steps, and sweeps of parameters."""
