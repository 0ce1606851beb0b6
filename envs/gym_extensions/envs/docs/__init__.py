"""Writes the documentation of the environments: the sheets of all tasks, pages and pictures."""
