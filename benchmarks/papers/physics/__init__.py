"""Measurements of grains against kinetic theory and hydrodynamics: a module for each part of docs/grains_physics.md."""
