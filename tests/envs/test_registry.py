"""What holds for every registered MuJoCo task."""

from __future__ import annotations

import pickle
import warnings

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.registry import TASKS
from gym_extensions.envs import make
from gym_extensions.errors import BenchError

MUJOCO = [row.id for row in TASKS.values() if row.base != "Navigation"]


def actions_for(env: gym.Env, steps: int) -> np.ndarray:
    space = env.action_space
    return np.random.default_rng(3).uniform(space.low, space.high, (steps, *space.shape)).astype(np.float32)


def rollout(env: gym.Env, actions: np.ndarray) -> list:
    outcomes = []
    for action in actions:
        observation, reward, terminated, _, _ = env.step(action)
        outcomes.append((observation.tolist(), float(reward), bool(terminated)))
    return outcomes


@pytest.mark.parametrize("task_id", MUJOCO)
def test_every_task_passes_gymnasiums_checker(task_id: str) -> None:
    env = gym.make(task_id)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # Unbounded observations and asymmetric actions are Gymnasium's own bodies' too.
        warnings.filterwarnings("ignore", message=".*Box (observation|action) space.*")
        warnings.filterwarnings("ignore", message=".*For Box action spaces.*")
        check_env(env.unwrapped, skip_render_check=True)
    assert env.spec is not None and env.spec.max_episode_steps == env.unwrapped.task.max_steps


@pytest.mark.parametrize("task_id", MUJOCO)
def test_the_same_seed_gives_the_same_episode_also_after_pickling(task_id: str) -> None:
    first = make(task_id)
    second = pickle.loads(pickle.dumps(make(task_id)))  # noqa: S301
    assert second.unwrapped.task == first.unwrapped.task
    actions = actions_for(first, 30)
    starts = [env.reset(seed=7)[0] for env in (first, second)]
    np.testing.assert_array_equal(*starts)
    assert rollout(first, actions) == rollout(second, actions)
    assert not np.array_equal(first.reset(seed=8)[0], starts[0])


@pytest.mark.parametrize("task_id", MUJOCO)
def test_a_state_saved_in_mid_episode_continues_bit_for_bit_elsewhere(task_id: str) -> None:
    env, elsewhere = make(task_id).unwrapped, make(task_id).unwrapped
    actions = actions_for(env, 40)
    env.reset(seed=4)
    rollout(env, actions[:20])
    saved = env.save_state()
    assert all(value.dtype == np.float64 for value in saved.values())
    expected = rollout(env, actions[20:])
    elsewhere.reset(seed=5)
    rollout(elsewhere, actions[:3])
    elsewhere.restore_state(saved)
    assert rollout(elsewhere, actions[20:]) == expected
    env.restore_state(saved)
    assert rollout(env, actions[20:]) == expected


@pytest.mark.parametrize("task_id", MUJOCO)
def test_without_derived_values_a_state_continues_from_the_second_step(task_id: str) -> None:
    env = make(task_id).unwrapped
    actions = actions_for(env, 30)
    env.reset(seed=4)
    rollout(env, actions[:20])
    saved = {name: value for name, value in env.save_state().items() if not name.startswith("derived_")}
    expected = rollout(env, actions[20:])
    env.reset(seed=4)
    env.restore_state(saved)
    found = rollout(env, actions[20:])
    assert found[1:] == expected[1:]
    assert found[0][0] == expected[0][0]


def test_vector_environments_agree_with_the_single_one() -> None:
    task_id = "gym_extensions/HopperGravityHalf-v0"
    single = make(task_id)
    actions = actions_for(single, 10)
    single.reset(seed=1)
    expected = [single.step(action)[0] for action in actions]
    for mode in ("sync", "async"):
        lanes = gym.make_vec(task_id, num_envs=2, vectorization_mode=mode)
        lanes.reset(seed=[1, 2])
        for action, observation in zip(actions, expected, strict=True):
            seen = lanes.step(np.stack([action, action]))[0]
            np.testing.assert_array_equal(seen[0], observation)
        lanes.close()


def test_a_time_limit_of_ones_own_ends_the_episode() -> None:
    env = make("HalfCheetah", max_steps=3)
    env.reset(seed=0)
    assert [env.step(np.zeros(6, np.float32))[3] for _ in range(3)] == [False, False, True]
    assert env.unwrapped.task.max_steps == 3


def test_every_group_lists_registered_tasks() -> None:
    for group in GROUPS.values():
        assert all(task_id in gym.registry for task_id in group.task_ids), group.id
        assert len(set(group.task_ids)) == len(group.task_ids) > 1


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("HopperGravtyHalf", "There is no task 'HopperGravtyHalf'. Did you mean 'HopperGravityHalf'?"),
        (
            "gym_extensions/hopper-v0",
            "There is no task 'gym_extensions/hopper-v0'. Did you mean 'gym_extensions/Hopper-v0'?",
        ),
    ],
)
def test_an_unknown_task_is_refused_with_the_closest_name(name: str, text: str) -> None:
    with pytest.raises(BenchError) as caught:
        make(name)
    assert str(caught.value) == text
