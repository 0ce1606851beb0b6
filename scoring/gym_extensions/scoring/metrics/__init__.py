"""Computes metrics from returns, with one formula per metric."""
