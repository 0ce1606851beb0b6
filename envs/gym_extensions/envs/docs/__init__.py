"""Writes the documentation of the environments: the descriptions of all tasks, pages and pictures."""
