"""Writes the traces of a submission's audit sample, and repeats episodes whose traces were not kept."""
