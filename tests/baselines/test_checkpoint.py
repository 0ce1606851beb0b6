"""Checkpoints of arrays and random generators."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gym_extensions.baselines.agent import (
    load_arrays,
    restore_generator,
    save_arrays,
    saved_generator,
)


def test_arrays_are_read_back_from_exactly_the_given_path(tmp_path: Path) -> None:
    path = tmp_path / "agent.partial"
    save_arrays(path, weights=np.arange(3.0), count=np.array(7))
    assert [each.name for each in tmp_path.iterdir()] == ["agent.partial"]
    arrays = load_arrays(path)
    assert arrays["weights"].tolist() == [0.0, 1.0, 2.0]
    assert int(arrays["count"]) == 7


def test_a_restored_generator_continues_with_the_same_numbers() -> None:
    original, restored = np.random.default_rng(1), np.random.default_rng(2)
    original.normal(size=5)
    restore_generator(restored, saved_generator(original))
    assert restored.normal(size=3).tolist() == original.normal(size=3).tolist()
