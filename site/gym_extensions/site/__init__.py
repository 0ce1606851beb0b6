"""Builds the leaderboard, a static site, from scorecards. Loads no simulator and no torch."""

from pathlib import Path

FOLDER = Path(__file__).parent
"""The folder of this package."""
SITE_ASSETS = Path(".site-assets")
"""Where ``make site-assets`` puts MuJoCo for the browser, in the current folder."""
