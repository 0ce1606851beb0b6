"""Trains, selects and measures the experts: ``python -m gym_extensions.baselines.experts``."""
