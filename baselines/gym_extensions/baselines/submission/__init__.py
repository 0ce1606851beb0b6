"""Writes a submission: merges finished runs, draws the audit sample, keeps the manifest."""
