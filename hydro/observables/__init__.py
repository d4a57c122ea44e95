"""Numbers that describe a state."""
