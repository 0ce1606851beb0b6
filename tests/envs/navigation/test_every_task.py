"""Every navigation task: single and vector environments agree, and observations are in their spaces."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pytest
from gymnasium.spaces import Box
from gymnasium.vector import SyncVectorEnv
from numpy.typing import NDArray

from gym_extensions.catalog.groups import group
from gym_extensions.catalog.tasks import FAMILIES, customize
from gym_extensions.catalog.variations import Course
from gym_extensions.envs import Gravity, make, make_vec
from gym_extensions.errors import BenchError

OF_A_FAMILY = {family: group(f"nav-{family}").task_ids for family in FAMILIES}


def random_actions(steps: int, num_envs: int, seed: int = 3) -> NDArray[np.float32]:
    return np.random.default_rng(seed).uniform(-5, 5, (steps, num_envs, 2)).astype(np.float32)


@pytest.mark.parametrize("family", FAMILIES)
def test_a_batch_is_bit_for_bit_the_single_environments_through_ends_and_resets(family: str) -> None:
    # Short episodes, so that every lane meets its limit at another step, over all thirty tasks of the family.
    limits = range(20, 50)
    tasks = [
        customize(name, max_steps=limit) for name, limit in zip(OF_A_FAMILY[family], limits, strict=True)
    ]
    batch: Any = make_vec(tasks, 30)
    sync = SyncVectorEnv([partial(make, task) for task in tasks])
    seeds: list[int | None] = list(range(100, 130))
    np.testing.assert_array_equal(batch.reset(seed=seeds)[0], sync.reset(seed=seeds)[0])
    for action in random_actions(120, 30):
        batch_step, sync_step = batch.step(action), sync.step(action)
        assert batch_step[4].keys() == sync_step[4].keys()
        parts = [(step[:4], step[4].values()) for step in (batch_step, sync_step)]
        for mine, theirs in zip(*([*arrays, *infos] for arrays, infos in parts), strict=True):
            np.testing.assert_array_equal(mine, theirs)
            assert mine.dtype == theirs.dtype
    positions = [env.unwrapped.position for env in sync.envs]  # type: ignore[attr-defined]
    np.testing.assert_array_equal(batch.states()["position"], positions)
    assert batch.call("task") == tuple(tasks)


@pytest.mark.parametrize("family", FAMILIES)
def test_observations_of_30000_random_steps_are_in_the_space(family: str) -> None:
    num_envs = 60
    batch = make_vec(OF_A_FAMILY[family], num_envs)
    space = batch.single_observation_space
    assert isinstance(space, Box)
    observations, _ = batch.reset(seed=0)
    rewards = set()
    # Runs of one action press against walls and corners, which single random steps hardly do.
    for block in range(50):
        action = random_actions(1, num_envs, seed=block)[0]
        for _ in range(10):
            assert observations.dtype == space.dtype
            assert (observations >= space.low).all()
            assert (observations <= space.high).all()
            observations, reward, _, _, _ = batch.step(action)
            rewards |= set(reward.tolist())
    assert rewards <= {-1.0, -6.0, 9.0, 0.0}
    assert {-1.0, -6.0} < rewards


def test_body_variations_and_courses_do_not_mix() -> None:
    with pytest.raises(BenchError) as caught:
        make("State-Based-Navigation-2d-Map0-Goal0", [Gravity(0.5)])
    assert caught.value.code == "bad-course"
    assert "its variations also include Gravity(factor=0.5)." in str(caught.value)
    with pytest.raises(BenchError) as caught:
        make("Hopper", [Course("state", 0, 0)])
    assert caught.value.code == "misplaced-variation"
