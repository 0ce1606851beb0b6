"""Which observations of a task are sampled."""

from __future__ import annotations

import numpy as np

from gym_extensions.baselines.algorithms.continual import StateSample


def sampled(size: int, steps: int, batch: int) -> list[int]:
    sample = StateSample(size, steps)
    for start in range(0, steps, batch):
        sample.add(np.arange(start, min(start + batch, steps))[:, None])
    return sample.observations[:, 0].tolist()  # type: ignore[no-any-return]


def test_every_kth_observation_of_the_last_half_is_sampled() -> None:
    assert sampled(size=4, steps=24, batch=5) == [12, 15, 18, 21]


def test_an_even_distance_is_made_odd() -> None:
    assert sampled(size=3, steps=24, batch=24) == [12, 15, 18]


def test_a_short_task_gives_what_it_has() -> None:
    assert sampled(size=100, steps=6, batch=2) == [3, 4, 5]


def test_a_method_that_needs_no_states_samples_none() -> None:
    assert sampled(size=0, steps=10, batch=5) == []
