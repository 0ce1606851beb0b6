"""What variations do while the simulation runs.

One module per variation: its pure functions, and its effect on one environment and on many.
"""
