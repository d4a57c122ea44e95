"""Running: the main loop, what looks on (trackers), and what is kept (checkpoints, history, summary)."""
