"""Runs the policies of entries. No other package of scoring/ starts a simulator."""
