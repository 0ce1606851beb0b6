"""Submissions whose traces are drawn again."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest


@pytest.fixture
def trpo(trpo_submission: Path, tmp_path: Path) -> Path:
    """A deterministic agent with policies, as git contains it: without ``.progress``."""
    ignore = shutil.ignore_patterns(".progress")
    return Path(shutil.copytree(trpo_submission, tmp_path / "trpo", ignore=ignore))


@pytest.fixture
def random(random_submission: Path, tmp_path: Path) -> Path:
    """An agent that draws its actions with a generator of its own, with the traces of all episodes."""
    return Path(shutil.copytree(random_submission, tmp_path / "random"))
