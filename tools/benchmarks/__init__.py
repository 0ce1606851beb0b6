"""Measures speed, and the error rates of intervals, tests and the core board."""
