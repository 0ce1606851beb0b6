"""Run-time variations: what a variation does while the simulation runs, one module each."""
