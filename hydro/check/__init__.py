"""What can be said of a deck before it is run: scales, and how well the assumptions of the equations hold."""
