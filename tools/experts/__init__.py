"""Trains, selects and measures the experts: ``python -m tools.experts``."""
