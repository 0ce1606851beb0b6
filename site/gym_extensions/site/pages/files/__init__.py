"""Modules that write files which pages link to and show."""
