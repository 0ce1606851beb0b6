"""Runs the policies of submissions. No other package of scoring/ starts a simulator."""
