"""Differences between a task and its base body, with one module per kind of variation."""
