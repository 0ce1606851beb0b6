"""Builds the leaderboard, a static site, from scorecards. Loads no simulator and no torch."""

from pathlib import Path

FOLDER = Path(__file__).parent
"""The folder of this package."""


def bundled(name: str, source: str) -> Path:
    """A file or folder that an installed package has as ``name``, and a source tree at ``source``."""
    return path if (path := FOLDER / name).exists() else FOLDER.parents[2] / source
