"""Measures the floors and ceilings that normalize scores, and writes a version of the references."""
