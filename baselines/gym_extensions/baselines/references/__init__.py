"""Writes and checks the references that normalize scores: their measurement, and the command."""
