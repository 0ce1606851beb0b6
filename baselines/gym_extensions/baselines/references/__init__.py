"""Measures floors and ceilings, and writes a version of the references."""
