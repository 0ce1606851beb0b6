"""A recorded submission that several tests read and none changes."""

from __future__ import annotations

from pathlib import Path

import pytest

from .recordings import TASKS, record_stage


@pytest.fixture(scope="session")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The policy zero, sequential and single, with stages and tasks in another order than in the log."""
    out = tmp_path_factory.mktemp("recorded") / "mine"
    for stage in (2, 0, 1):
        record_stage(out, stage=stage)
    for task in reversed(TASKS):
        record_stage(out, protocol="single", task=task.name, curves={task.name: [(500, -10.0), (1000, -9.0)]})
    return out
