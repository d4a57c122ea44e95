"""Steady states and their stability: extended and localized, marginal curves, branches."""
