"""Scorecards as terminal text, CSV, Markdown and JSON."""
