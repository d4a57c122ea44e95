"""Pictures of runs. Importing a module of this package imports matplotlib."""
