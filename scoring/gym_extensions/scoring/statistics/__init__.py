"""Means, intervals, tests and ranks over runs."""
