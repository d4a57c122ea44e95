"""The main loop, its trackers, and the books of a run."""
