"""Reports of runs: one HTML page that holds all it shows and needs no network."""
