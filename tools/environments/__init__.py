"""Writes the descriptions of all tasks, their pages and their pictures: ``python -m tools.environments``."""
