"""2-D navigation on occupancy grids. Numba is loaded when a task is built, not by importing this package."""
