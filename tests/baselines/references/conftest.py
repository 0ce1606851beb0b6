"""Measurements of few episodes, in this process."""

from __future__ import annotations

import pytest

from gym_extensions.baselines.references import measuring
from gym_extensions.baselines.workers import ThisProcess


@pytest.fixture(autouse=True)
def in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(measuring, "Workers", lambda _: ThisProcess())


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few episodes."""
    measurements = measuring.floor_measurements
    monkeypatch.setattr(measuring, "floor_measurements", lambda task, episodes=4: measurements(task, 4))
