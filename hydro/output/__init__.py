"""What runs write, and how it is read again: folders, checkpoints, files, tables."""
