"""Runs side by side: with a steady state, with other runs."""
