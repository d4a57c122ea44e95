"""The grains themselves: event-driven molecular dynamics of inelastic smooth hard disks in the box of a deck."""
