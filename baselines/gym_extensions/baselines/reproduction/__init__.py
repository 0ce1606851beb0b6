"""Retrains a run of a submission and compares it with the log."""
