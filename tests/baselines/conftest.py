"""Small submissions that several tests read. Tests that change one copy it first."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest

from gym_extensions.baselines import train

SHORT_GROUP = "hopper-motor-noise"
"""A group of two tasks: a fifth of the evaluation episodes of a group of five."""


def digests(folder: Path) -> dict[str, str]:
    """The sha256 of every finished file, by its path in the folder."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and ".progress" not in path.parts
    }


@pytest.fixture(scope="session")
def trpo_submission(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """trpo, sequential and joint, run 0, at the smoke budget."""
    folder = tmp_path_factory.mktemp("submissions") / "trpo"
    train("trpo", SHORT_GROUP, ["sequential", "joint"], "smoke", 0, out=folder)
    return folder


@pytest.fixture(scope="session")
def random_submission(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """random, single, run 0, at the smoke budget."""
    folder = tmp_path_factory.mktemp("submissions") / "random"
    train("random", "hopper-gravity", "single", "smoke", 0, out=folder)
    return folder
