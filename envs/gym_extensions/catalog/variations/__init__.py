"""Differences between a task and its base body: one module per kind of variation."""
