"""Measurements of few episodes, in this process."""

from __future__ import annotations

import pytest

from gym_extensions.baselines import workers
from gym_extensions.baselines.references import measuring


@pytest.fixture(autouse=True)
def in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    run = workers.run
    monkeypatch.setattr(workers, "run", lambda pending, listen, jobs: run(pending, listen, 0))


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few episodes."""
    measurements = measuring.floor_measurements
    monkeypatch.setattr(measuring, "floor_measurements", lambda task, episodes=4: measurements(task, 4))
