"""Where the books of grains keep what is summed and counted, event by event."""

# In `Grains.sums`: energy given by the driving wall, energy lost in collisions, their virial, momentum given to the
# walls at x = 0 and x = 1.
WALL_ENERGY, LOSS, VIRIAL, PUSH_LEFT, PUSH_RIGHT, SUMS = range(6)
# In `Grains.counts`: collisions, impacts on the driving wall, collisions that the contact time made elastic, stale
# events, changes of cell.
COLLISIONS, WALL_HITS, SOFT, STALE, CROSSINGS, COUNTS = range(6)
