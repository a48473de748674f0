"""Results files: the only code that touches HDF5."""
