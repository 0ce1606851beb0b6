"""A valid submission to change."""

from pathlib import Path

import pytest

from .examples import GROUP, CopySubmission


@pytest.fixture
def folder(good: CopySubmission, tmp_path: Path) -> Path:
    """The folder of a valid submission, alone in the folder of the test."""
    return good(GROUP, tmp_path)
