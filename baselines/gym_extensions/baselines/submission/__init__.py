"""Writes a submission: its logs, curves, audit sample and manifest."""
