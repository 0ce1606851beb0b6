"""Evaluates the policies of a submission on new seeds, and compares the returns with the log."""
