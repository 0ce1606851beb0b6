"""Every registered MuJoCo task: Gymnasium's checker, reproducibility, saved states."""

from __future__ import annotations

import pickle
import warnings
from dataclasses import dataclass
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from numpy.typing import NDArray

from gym_extensions.catalog.registry import TASKS
from gym_extensions.envs import make
from gym_extensions.envs.make import construct_mujoco
from gym_extensions.envs.mujoco.task_env import TaskEnv

MUJOCO = [row.id for row in TASKS.values() if row.base != "Navigation"]


def actions_for(env: TaskEnv, steps: int) -> NDArray[np.float32]:
    space = env.action_space
    return np.random.default_rng(3).uniform(space.low, space.high, (steps, *space.shape)).astype(np.float32)


def rollout(env: TaskEnv, actions: NDArray[np.float32]) -> list[tuple[object, float, bool]]:
    outcomes: list[tuple[object, float, bool]] = []
    for action in actions:
        observation, reward, terminated, _, _ = env.step(action)
        outcomes.append((observation.tolist(), float(reward), bool(terminated)))
    return outcomes


@pytest.mark.parametrize("task_id", MUJOCO)
def test_every_task_passes_gymnasiums_checker(task_id: str) -> None:
    env = gym.make(task_id)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # Gymnasium's own bodies have unbounded observations and asymmetric actions too.
        warnings.filterwarnings("ignore", message=".*Box (observation|action) space.*")
        warnings.filterwarnings("ignore", message=".*For Box action spaces.*")
        check_env(env.unwrapped, skip_render_check=True)
    assert env.spec is not None and env.spec.max_episode_steps == TASKS[task_id].max_steps


@dataclass(frozen=True)
class Interrupted:
    """Two environments of a task; the state of the first in mid-episode, and what follows there."""

    env: TaskEnv
    elsewhere: TaskEnv
    saved: dict[str, NDArray[Any]]
    actions: NDArray[np.float32]
    expected: list[tuple[object, float, bool]]


@pytest.fixture(scope="module", params=MUJOCO)
def pair(request: pytest.FixtureRequest) -> tuple[TaskEnv, TaskEnv]:
    """An environment of a task and its pickled copy, which the tests of the task share."""
    first = construct_mujoco(request.param)
    return first, pickle.loads(pickle.dumps(first))  # noqa: S301


@pytest.fixture(scope="module")
def interrupted(pair: tuple[TaskEnv, TaskEnv]) -> Interrupted:
    env = pair[0]
    actions = actions_for(env, 20)
    env.reset(seed=4)
    rollout(env, actions[:15])
    saved = env.save_state()
    return Interrupted(*pair, saved, actions[15:], rollout(env, actions[15:]))


def test_the_same_seed_gives_the_same_episode_also_after_pickling(pair: tuple[TaskEnv, TaskEnv]) -> None:
    first, second = pair
    assert second.task == first.task
    actions = actions_for(first, 10)
    start = first.reset(seed=7)[0]
    np.testing.assert_array_equal(second.reset(seed=7)[0], start)
    assert rollout(first, actions) == rollout(second, actions)
    assert not np.array_equal(first.reset(seed=8)[0], start)


def test_a_state_saved_in_mid_episode_continues_bit_for_bit_elsewhere(interrupted: Interrupted) -> None:
    env, elsewhere, actions = interrupted.env, interrupted.elsewhere, interrupted.actions
    assert all(value.dtype == np.float64 for value in interrupted.saved.values())
    elsewhere.reset(seed=5)
    rollout(elsewhere, actions[:3])
    elsewhere.restore_state(interrupted.saved)
    assert rollout(elsewhere, actions) == interrupted.expected
    env.restore_state(interrupted.saved)
    assert rollout(env, actions) == interrupted.expected


def test_without_derived_values_a_state_continues_from_the_second_step(interrupted: Interrupted) -> None:
    env, expected = interrupted.env, interrupted.expected
    saved = {name: value for name, value in interrupted.saved.items() if not name.startswith("derived_")}
    env.reset(seed=4)
    env.restore_state(saved)
    continued = rollout(env, interrupted.actions)
    assert continued[1:] == expected[1:]
    assert continued[0][0] == expected[0][0]


def test_vector_environments_agree_with_the_single_one() -> None:
    task_id = "gym_extensions/HopperGravityHalf-v0"
    single = construct_mujoco(task_id)
    actions = actions_for(single, 10)
    single.reset(seed=1)
    expected = [single.step(action)[0] for action in actions]
    for mode in ("sync", "async"):
        vector: Any = gym.make_vec(task_id, num_envs=2, vectorization_mode=mode)
        vector.reset(seed=[1, 2])
        for action, observation in zip(actions, expected, strict=True):
            seen = vector.step(np.stack([action, action]))[0]
            np.testing.assert_array_equal(seen[0], observation)
        vector.close()


def test_a_custom_time_limit_truncates_the_episode() -> None:
    env = make("HalfCheetah", max_steps=3)
    env.reset(seed=0)
    assert [env.step(np.zeros(6, np.float32))[3] for _ in range(3)] == [False, False, True]
    assert env.get_wrapper_attr("task").max_steps == 3
