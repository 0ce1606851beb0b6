"""What variations do while the simulation runs, on one environment and on many."""
