"""2-D navigation on occupancy grids; numba is loaded when a task is built, not by importing this."""
