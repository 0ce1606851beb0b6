"""Scorecards and boards as text on the screen, as data frames and as CSV."""
