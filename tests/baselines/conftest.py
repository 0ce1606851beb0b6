"""Small submissions that several tests look at; made once, copied where a test changes them."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest

from gym_extensions.baselines.train import train


def digests(folder: Path) -> dict[str, str]:
    """The sha256 of every finished file by its path."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and ".progress" not in path.parts
    }


@pytest.fixture(scope="session")
def trpo_submission(tmp_path_factory) -> Path:
    """trpo, sequential and joint, run 0, at the smoke budget."""
    folder = tmp_path_factory.mktemp("made") / "trpo"
    train("trpo", "hopper-gravity", ["sequential", "joint"], "smoke", 0, out=folder)
    return folder


@pytest.fixture(scope="session")
def random_submission(tmp_path_factory) -> Path:
    """random, single, run 0, at the smoke budget."""
    folder = tmp_path_factory.mktemp("made") / "random"
    train("random", "hopper-gravity", "single", "smoke", 0, out=folder)
    return folder
