"""Every navigation task: Gymnasium's checker, seeds, vector environments, errors."""

from __future__ import annotations

import pickle
import warnings
from functools import partial
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.spaces import Box
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv
from numpy.typing import NDArray

from gym_extensions.catalog.custom import customize
from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.groups import group
from gym_extensions.catalog.navigation_tasks import FAMILIES
from gym_extensions.catalog.registry import TASKS
from gym_extensions.catalog.variations.maps import Course
from gym_extensions.envs import Gravity, make, make_vec
from gym_extensions.errors import BenchError

NAVIGATION = [row.id for row in TASKS.values() if row.base == "Navigation"]
OF_A_FAMILY = {family: group(f"nav-{family}").task_ids for family in FAMILIES}


def random_actions(steps: int, num_envs: int, seed: int = 3) -> NDArray[np.float32]:
    return np.random.default_rng(seed).uniform(-5, 5, (steps, num_envs, 2)).astype(np.float32)


@pytest.mark.parametrize("task_id", NAVIGATION)
def test_every_task_passes_gymnasiums_checker_without_a_warning(task_id: str) -> None:
    env = gym.make(task_id)
    assert env.spec is not None and env.spec.max_episode_steps == 1000
    assert env.get_wrapper_attr("task") == TASKS[task_id]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # The paper's actions are displacements in units, not normalised.
        warnings.filterwarnings("ignore", message=".*For Box action spaces.*")
        # Frames are checked in test_rendering.py.
        check_env(env.unwrapped, skip_render_check=True)


@pytest.mark.parametrize("task_id", NAVIGATION)
def test_every_task_has_a_different_fingerprint(task_id: str) -> None:
    others = {published(other) for other in NAVIGATION if other != task_id}
    assert published(task_id) not in others


@pytest.mark.parametrize("family", FAMILIES)
def test_the_same_seeds_give_the_same_episodes_single_sync_async_and_batch(family: str) -> None:
    tasks = OF_A_FAMILY[family][4:7]
    makers = [partial(make, name) for name in tasks]
    vectors: list[Any] = [SyncVectorEnv(makers), AsyncVectorEnv(makers), make_vec(tasks, 3)]
    actions = random_actions(30, 3)
    seeds = [5, 6, 2**31 - 1]
    firsts = [vector.reset(seed=seeds)[0] for vector in vectors]
    outcomes = [[vector.step(action)[:4] for action in actions] for vector in vectors]
    for index, name in enumerate(tasks):
        env = make(name)
        first = env.reset(seed=seeds[index])[0]
        expected = [env.step(action[index])[:4] for action in actions]
        for vector_first, outcome in zip(firsts, outcomes, strict=True):
            np.testing.assert_array_equal(vector_first[index], first)
            for mine, theirs in zip(expected, outcome, strict=True):
                np.testing.assert_array_equal(theirs[0][index], mine[0])
                assert tuple(part[index] for part in theirs[1:]) == mine[1:]
    for vector in vectors:
        vector.close()


@pytest.mark.parametrize("family", FAMILIES)
def test_a_batch_is_bit_for_bit_the_single_environments_through_ends_and_resets(family: str) -> None:
    # Short episodes, so that every lane meets its limit at another step, over all thirty tasks of the family.
    limits = range(20, 50)
    tasks = [
        customize(name, max_steps=limit) for name, limit in zip(OF_A_FAMILY[family], limits, strict=True)
    ]
    batch: Any = make_vec(tasks, 30)
    sync = SyncVectorEnv([partial(make, row) for row in tasks])
    seeds: list[int | None] = list(range(100, 130))
    np.testing.assert_array_equal(batch.reset(seed=seeds)[0], sync.reset(seed=seeds)[0])
    for action in random_actions(120, 30):
        batch_step, sync_step = batch.step(action), sync.step(action)
        assert batch_step[4].keys() == sync_step[4].keys()
        parts = [(step[:4], step[4].values()) for step in (batch_step, sync_step)]
        for mine, theirs in zip(*([*arrays, *infos] for arrays, infos in parts), strict=True):
            np.testing.assert_array_equal(mine, theirs)
            assert mine.dtype == theirs.dtype
    saved = zip(batch.call("save_state"), sync.call("save_state"), strict=True)
    assert all(mine["position"].tolist() == theirs["position"].tolist() for mine, theirs in saved)
    assert batch.call("task") == tuple(tasks)


def test_an_int_seed_is_spawned_and_none_continues_the_generators() -> None:
    tasks = OF_A_FAMILY["state"][:2]
    env, twin = make_vec(tasks, 4), make_vec(tasks, 4)
    first = env.reset(seed=9)[0]
    np.testing.assert_array_equal(first, twin.reset(seed=9)[0])
    second = env.reset()[0]
    assert not np.array_equal(first, second)
    np.testing.assert_array_equal(second, twin.reset()[0])
    assert len({tuple(row) for row in first.tolist()}) == 4


def test_a_reset_mask_resets_only_its_environments() -> None:
    batch = make_vec(OF_A_FAMILY["state"][0], 3)
    first = batch.reset(seed=1)[0]
    again = batch.reset(options={"reset_mask": np.array([False, True, False])})[0]
    assert (first == again).all(axis=1).tolist() == [True, False, True]


@pytest.mark.parametrize("family", FAMILIES)
def test_a_pickled_environment_becomes_a_new_one_of_the_same_task(family: str) -> None:
    env: Any = make(OF_A_FAMILY[family][3])
    env.reset(seed=1)
    again = pickle.loads(pickle.dumps(env))  # noqa: S301
    assert again.unwrapped.task == env.unwrapped.task
    np.testing.assert_array_equal(again.reset(seed=2)[0], env.reset(seed=2)[0])
    for action in random_actions(20, 1)[:, 0]:
        mine, theirs = env.step(action), again.step(action)
        np.testing.assert_array_equal(mine[0], theirs[0])
        assert mine[1:] == theirs[1:]


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


def test_tasks_of_two_families_raise_an_error() -> None:
    with pytest.raises(BenchError) as caught:
        make_vec([OF_A_FAMILY["state"][0], OF_A_FAMILY["image"][0]], 2)
    assert str(caught.value) == (
        "make_vec: The tasks have different observations: image, state. Give tasks of one navigation family."
    )


def test_body_variations_and_courses_do_not_mix() -> None:
    with pytest.raises(BenchError) as caught:
        make("State-Based-Navigation-2d-Map0-Goal0", [Gravity(0.5)])
    assert caught.value.code == "bad-course"
    assert "its variations also include Gravity(factor=0.5)." in str(caught.value)
    with pytest.raises(BenchError) as caught:
        make("Hopper", [Course("state", 0, 0)])
    assert str(caught.value) == (
        "gym_extensions/Hopper.Course-state-0-0-v0: Course does not fit Hopper. It fits Navigation."
    )


def test_a_misspelled_name_gets_a_hint() -> None:
    with pytest.raises(BenchError, match=r"Did you mean 'Image-Based-Navigation-2d-Map1-Goal2'\?"):
        make("Image-Based-Navigation-2dMap1-Goal2")
