"""Gymnasium's and Stable-Baselines3's vector environments agree with the single environments."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from gymnasium.spaces import Box
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.registry import TASKS, task
from gym_extensions.envs import group, make, make_vec
from gym_extensions.envs.make import construct_mujoco

MUJOCO_GROUPS = [name for name, row in GROUPS.items() if row.tasks[0].base != "Navigation"]
IN_PROCESSES = {GROUPS[name].tasks[0].base: name for name in reversed(MUJOCO_GROUPS)}.values()
"""The first group of each body, whose tasks also run in processes: starting these takes most of the time."""
VARIED = [row.id for row in TASKS.values() if row.base != "Navigation" and row.variations]


@pytest.mark.parametrize("name", MUJOCO_GROUPS)
def test_sync_and_async_vector_environments_agree_with_single_ones(name: str) -> None:
    rows = group(name).tasks
    makers = [partial(make, row) for row in rows]
    singles = [make(row) for row in rows]
    space = construct_mujoco(rows[0]).action_space
    shape = (4, len(rows), *space.shape)
    actions = np.random.default_rng(1).uniform(space.low, space.high, shape).astype(np.float32)
    seeds: list[int | None] = list(range(len(rows)))
    expected = [[env.reset(seed=seed)[0] for env, seed in zip(singles, seeds, strict=True)]]
    expected += [[env.step(a)[0] for env, a in zip(singles, step, strict=True)] for step in actions]
    for kind in (SyncVectorEnv, AsyncVectorEnv) if name in IN_PROCESSES else (SyncVectorEnv,):
        vector = kind(makers)
        np.testing.assert_array_equal(vector.reset(seed=seeds)[0], expected[0])
        for step, row in zip(actions, expected[1:], strict=True):
            np.testing.assert_array_equal(vector.step(step)[0], row)
        vector.close()


@pytest.mark.parametrize("task_id", VARIED)
def test_a_varied_task_differs_from_its_base(task_id: str) -> None:
    row = task(task_id)
    varied, base = construct_mujoco(row), construct_mujoco(row.base)
    start, base_start = varied.reset(seed=1)[0], base.reset(seed=1)[0]
    differs = not np.array_equal(start, base_start)
    for action in np.random.default_rng(2).uniform(-1, 1, (30, *base.action_space.shape)):
        if differs:
            break
        (seen, reward), (base_seen, base_reward) = (
            env.step(action.astype(np.float32))[:2] for env in (varied, base)
        )
        differs = reward != base_reward or not np.array_equal(seen, base_seen)
    assert differs


FAMILIES = ("HopperWall", "Walker2dNoisyWall", "HalfCheetahWall", "HumanoidNoisyWall", "Pusher", "Striker")


@pytest.mark.parametrize("name", FAMILIES)
def test_observations_are_in_the_observation_space(name: str) -> None:
    env = make(name)
    env.action_space.seed(0)
    assert env.reset(seed=0)[0] in env.observation_space
    for _ in range(400):
        seen, _, terminated, truncated, _ = env.step(env.action_space.sample())
        assert seen in env.observation_space
        assert np.isfinite(seen).all()
        if terminated or truncated:
            env.reset()


@pytest.mark.slow
@pytest.mark.parametrize("name", FAMILIES)
def test_observations_of_100000_steps_are_in_the_observation_space(name: str) -> None:
    env = make_vec(name, 50)
    env.action_space.seed(0)
    env.reset(seed=0)
    space = env.single_observation_space
    assert isinstance(space, Box)
    for _ in range(2000):
        seen = env.step(env.action_space.sample())[0]
        assert np.isfinite(seen).all()
        assert ((seen >= space.low) & (seen <= space.high)).all()
    env.close()


def test_stable_baselines3_vector_environments_accept_the_tasks() -> None:
    vec = pytest.importorskip("stable_baselines3.common.vec_env")
    env = vec.DummyVecEnv([lambda: make("HopperWall"), lambda: make("HopperWithSensor")])
    env.seed(0)
    assert env.reset().shape == (2, 21)
    assert env.step(np.zeros((2, 3), np.float32))[0].shape == (2, 21)
    env.close()
