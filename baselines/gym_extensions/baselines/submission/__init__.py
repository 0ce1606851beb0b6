"""Writes a submission with its logs, curves, audit sample and manifest."""
