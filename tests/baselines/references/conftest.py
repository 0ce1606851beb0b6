"""Measurements of few episodes, in this process."""

from __future__ import annotations

import pytest

from gym_extensions.baselines import workers
from gym_extensions.baselines.references import measuring


def make_quick(patch: pytest.MonkeyPatch, episodes: int) -> None:
    """Measures floors with this many episodes, in this process."""
    measurements, run = measuring.floor_measurements, workers.run
    patch.setattr(measuring, "floor_measurements", lambda task, _=None: measurements(task, episodes))
    patch.setattr(workers, "run", lambda pending, listen, jobs: run(pending, listen, 0))


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    make_quick(monkeypatch, 4)
