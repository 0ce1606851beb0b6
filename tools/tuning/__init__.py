"""Tunes every method by one rule: README.md."""
