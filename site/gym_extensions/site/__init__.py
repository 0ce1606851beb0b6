"""Builds the leaderboard, a static site, from scorecards. Loads no simulator and no torch."""
