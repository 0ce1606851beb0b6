"""Writes results in the formats of other projects, into a folder and without any network."""
