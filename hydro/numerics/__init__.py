"""Numerical tools that know no physics."""
