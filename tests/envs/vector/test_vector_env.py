"""make_vec: seeds, ends of episodes and saved states."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from gym_extensions.catalog.registry import task
from gym_extensions.envs import make
from gym_extensions.envs import make_vec as typed_make_vec
from gym_extensions.envs.make import construct_mujoco

HOPPERS = ["HopperGravityHalf", "Hopper", "HopperGravityOneAndHalf"]


def make_vec(*args: Any, **kwargs: Any) -> Any:
    """``make_vec`` without its type: Gymnasium's VectorEnv declares neither ``call`` nor lists of seeds."""
    return typed_make_vec(*args, **kwargs)


def actions(env: Any, steps: int, seed: int = 0) -> Any:
    """Random actions, (steps, num_envs, act), float32."""
    space = env.single_action_space
    drawn = np.random.default_rng(seed).uniform(space.low, space.high, (steps, env.num_envs, *space.shape))
    return drawn.astype(np.float32)


def play(env: Any, actions: Any) -> list[Any]:
    """Everything that the steps return, as arrays."""
    return [np.concatenate([np.ravel(part) for part in env.step(row)[:4]]) for row in actions]


def test_environment_i_has_task_i_modulo_the_number_of_tasks() -> None:
    tasks = make_vec(HOPPERS, 5).call("task")
    assert [row.name for row in tasks] == [*HOPPERS, *HOPPERS[:2]]


def test_the_vector_environment_declares_its_spaces_and_autoreset_mode() -> None:
    env = make_vec(HOPPERS, 4)
    assert env.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
    assert env.observation_space.shape == (4, 11)
    assert env.action_space.shape == (4, 3)
    assert env.observation_space.contains(env.reset(seed=1)[0])


def test_an_int_seed_gives_environment_i_that_seed_plus_i_as_in_gymnasium() -> None:
    env = make_vec("Hopper", 3)
    observations, _ = env.reset(seed=7)
    assert env.call("np_random_seed") == (7, 8, 9)
    assert np.array_equal(observations[2], make("Hopper").reset(seed=9)[0])


def test_a_seed_in_a_list_starts_its_environment_like_the_single_one() -> None:
    observations, _ = make_vec(HOPPERS, 3).reset(seed=[5, 9, 2**32 + 1])
    singles = [make(name).reset(seed=seed)[0] for name, seed in zip(HOPPERS, (5, 9, 2**32 + 1), strict=True)]
    assert np.array_equal(observations, singles)


def test_an_environment_without_a_seed_continues_with_its_generator() -> None:
    env, single = make_vec("Walker2d", 2), make("Walker2d")
    env.reset(seed=[3, 4])
    single.reset(seed=4)
    assert np.array_equal(env.reset(seed=[8, None])[0][1], single.reset()[0])
    assert np.array_equal(env.reset()[0][1], single.reset()[0])


def test_environments_without_any_seed_start_differently() -> None:
    first, second = make_vec("Hopper", 2).reset()[0]
    assert not np.array_equal(first, second)


@pytest.mark.parametrize("names", [HOPPERS, ["Humanoid"], ["HalfCheetah", "Walker2d"]])
def test_results_do_not_depend_on_the_number_of_threads(names: list[str]) -> None:
    results = []
    for threads in (1, 2, 5):
        env = make_vec(names, 6, num_threads=threads)
        env.reset(seed=2)
        results.append(play(env, actions(env, 60)))
        env.close()
    assert np.array_equal(results[0], results[1])
    assert np.array_equal(results[0], results[2])


def test_environments_of_different_layouts_run_together_if_their_spaces_are_equal() -> None:
    names = ["HalfCheetah", "Walker2dGravityHalf", "Walker2d"]
    mixed = make_vec(names, 6)
    apart = {name: make_vec(name, 2) for name in names}
    mixed.reset(seed=[1, 2, 3, 4, 5, 6])
    for index, name in enumerate(names):
        apart[name].reset(seed=[index + 1, index + 4])
    for row in actions(mixed, 120):
        combined = mixed.step(row)[:4]
        for index, name in enumerate(names):
            single = apart[name].step(row[index::3])[:4]
            assert all(np.array_equal(a[index::3], b) for a, b in zip(combined, single, strict=True))


def test_an_episode_is_truncated_at_its_limit_and_restarts_in_the_next_step() -> None:
    rows = [replace(task("HalfCheetah"), name="HalfCheetahShort", max_steps=limit) for limit in (3, 5)]
    env = make_vec(rows, 2)
    env.reset(seed=0)
    cuts, rewards = [], []
    for row in actions(env, 9):
        _, reward, terminated, truncated, _ = env.step(row)
        assert not terminated.any()
        cuts.append(truncated.tolist())
        rewards.append((reward == 0).tolist())
    assert [step for step, (first, _) in enumerate(cuts, 1) if first] == [3, 7]
    assert [step for step, (_, second) in enumerate(cuts, 1) if second] == [5]
    assert [step for step, (first, _) in enumerate(rewards, 1) if first] == [4, 8]
    assert [step for step, (_, second) in enumerate(rewards, 1) if second] == [6]


def test_observations_of_earlier_steps_do_not_change() -> None:
    env = make_vec("Humanoid", 2)
    first, _ = env.reset(seed=0)
    copy = first.copy()
    second = env.step(actions(env, 1)[0])[0]
    assert np.array_equal(first, copy)
    assert not np.array_equal(first, second)


def test_a_reset_mask_resets_only_its_environments() -> None:
    env, twin = make_vec("Hopper", 3), make_vec("Hopper", 3)
    for copy in (env, twin):
        copy.reset(seed=0)
        for row in actions(copy, 5):
            before = copy.step(row)[0]
    observations, _ = env.reset(seed=[9, 9, 9], options={"reset_mask": np.array([False, True, False])})
    assert np.array_equal(observations[[0, 2]], before[[0, 2]])
    assert np.array_equal(observations[1], make("Hopper").reset(seed=9)[0])
    row = actions(env, 1, seed=1)[0]
    assert np.array_equal(env.step(row)[0][[0, 2]], twin.step(row)[0][[0, 2]])


def test_states_are_saved_as_arrays_or_one_per_environment() -> None:
    env = make_vec("Humanoid", 3)
    env.reset(seed=0)
    env.step(actions(env, 1)[0])
    arrays, rows = env.save_states(), env.call("save_state")
    assert set(arrays) == {"qpos", "qvel", "qacc_warmstart", "time", "derived_xipos"}
    assert arrays["qpos"].shape == (3, 24)
    assert all(
        np.array_equal(arrays[name][index], rows[index][name]) for name in arrays for index in range(3)
    )
    assert all(value.dtype == np.float64 for value in rows[0].values())


STATEFUL = ["Hopper", "HalfCheetahNoisyWall", "HumanoidMotorNoise", "HumanoidStandupAndRunWall"]


@pytest.mark.parametrize("name", [*STATEFUL, "Pusher", "PusherTrackingGoal", "StrikerTrackingGoal"])
def test_a_restored_state_continues_bit_for_bit_in_any_environment(name: str) -> None:
    env, other = make_vec(name, 3), make_vec(name, 4)
    env.reset(seed=0)
    other.reset(seed=1)
    drawn = actions(env, 12)
    for row in drawn[:8]:
        env.step(row)
    states = env.save_states()
    other.restore_states({key: rows[[2, 0]] for key, rows in states.items()}, indices=[1, 3])
    for row in drawn[8:]:
        wide = np.zeros((4, row.shape[1]), np.float32)
        wide[[1, 3]] = row[[2, 0]]
        for mine, theirs in zip(other.step(wide)[:3], env.step(row)[:3], strict=True):
            assert np.array_equal(mine[[1, 3]], theirs[[2, 0]])


def test_a_saved_state_continues_in_the_single_environment() -> None:
    env, single = make_vec("Humanoid", 2), construct_mujoco("Humanoid")
    env.reset(seed=0)
    single.reset(seed=5)
    drawn = actions(env, 6)
    for row in drawn[:3]:
        env.step(row)
    single.restore_state(env.call("save_state")[1])
    for row in drawn[3:]:
        batched, expected = env.step(row), single.step(row[1])
        assert np.array_equal(batched[0][1], expected[0])
        assert batched[1][1] == expected[1]
