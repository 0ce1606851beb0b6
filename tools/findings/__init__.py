"""Writes docs/findings.md and docs/reproduction.md: ``python -m tools.findings``."""
