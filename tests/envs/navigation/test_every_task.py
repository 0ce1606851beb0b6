"""What holds for every navigation task, and for many of them at once."""

from __future__ import annotations

import pickle
import warnings

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv

from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.groups import group
from gym_extensions.catalog.navigation_tasks import FAMILIES
from gym_extensions.catalog.registry import TASKS
from gym_extensions.catalog.variations.maps import Course
from gym_extensions.envs import Gravity, make, make_vec
from gym_extensions.errors import BenchError

NAVIGATION = [row.id for row in TASKS.values() if row.base == "Navigation"]
OF_A_FAMILY = {family: group(f"nav-{family}").task_ids for family in FAMILIES}


def random_actions(steps: int, lanes: int, seed: int = 3) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-5, 5, (steps, lanes, 2)).astype(np.float32)


def test_there_are_150_tasks_in_five_groups_of_thirty_map_by_map() -> None:
    assert len(NAVIGATION) == len(set(NAVIGATION)) == 150
    patterns = {
        "nav-state": "State-Based-Navigation-2d-Map{}-Goal{}",
        "nav-state-goal": "State-Based-Navigation-2d-Map{}-Goal{}-KnownGoalPosition",
        "nav-range": "Limited-Range-Based-Navigation-2d-Map{}-Goal{}",
        "nav-range-known": "Limited-Range-Based-Navigation-2d-Map{}-Goal{}-KnownPositions",
        "nav-image": "Image-Based-Navigation-2d-Map{}-Goal{}",
    }
    for name, pattern in patterns.items():
        names = [pattern.format(number, goal) for number in range(10) for goal in range(3)]
        assert [task.name for task in group(name).tasks] == names
        assert group(name).id == f"{name}-v0"


@pytest.mark.parametrize("task_id", NAVIGATION)
def test_every_task_passes_gymnasiums_checker_without_a_warning(task_id: str) -> None:
    env = gym.make(task_id)
    assert env.spec is not None and env.spec.max_episode_steps == 1000
    assert env.unwrapped.task == TASKS[task_id]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # The paper's actions are displacements in units, not normalised.
        warnings.filterwarnings("ignore", message=".*For Box action spaces.*")
        # A window needs a display; frames are checked below.
        check_env(env.unwrapped, skip_render_check=True)


@pytest.mark.parametrize("task_id", [ids[7] for ids in OF_A_FAMILY.values()])
def test_frames_show_the_world_a_pixel_a_unit(task_id: str) -> None:
    env = gym.make(task_id, render_mode="rgb_array")
    env.reset(seed=0)
    frame = env.render()
    assert (frame.shape, frame.dtype) == ((480, 640, 3), np.uint8)
    x, y = env.unwrapped.save_state()["position"]
    assert frame[480 - round(y), round(x)].tolist() == [0, 0, 0]
    assert frame[0, 0].tolist() == [204, 153, 102]
    goal_x, goal_y = env.unwrapped.arena.goal
    assert frame[480 - round(goal_y), round(goal_x)].tolist() == [255, 0, 0]
    env.close()


@pytest.mark.parametrize("task_id", NAVIGATION)
def test_every_task_has_a_fingerprint_of_its_own(task_id: str) -> None:
    others = {published(other) for other in NAVIGATION if other != task_id}
    assert published(task_id) not in others


@pytest.mark.parametrize("family", FAMILIES)
def test_the_same_seeds_give_the_same_episodes_single_sync_async_and_batch(family: str) -> None:
    tasks = OF_A_FAMILY[family][4:7]
    makers = [lambda task=task: make(task) for task in tasks]
    vectors = [SyncVectorEnv(makers), AsyncVectorEnv(makers), make_vec(tasks, 3)]
    actions = random_actions(30, 3)
    seeds = [5, 6, 2**31 - 1]
    firsts = [vector.reset(seed=seeds)[0] for vector in vectors]
    outcomes = [[vector.step(action)[:4] for action in actions] for vector in vectors]
    for lane, task in enumerate(tasks):
        env = make(task)
        first = env.reset(seed=seeds[lane])[0]
        own = [env.step(action[lane])[:4] for action in actions]
        for vector_first, outcome in zip(firsts, outcomes, strict=True):
            np.testing.assert_array_equal(vector_first[lane], first)
            for mine, theirs in zip(own, outcome, strict=True):
                np.testing.assert_array_equal(theirs[0][lane], mine[0])
                assert tuple(part[lane] for part in theirs[1:]) == mine[1:]
    for vector in vectors:
        vector.close()


@pytest.mark.parametrize("family", FAMILIES)
def test_a_batch_is_bit_for_bit_the_single_environments_through_ends_and_resets(family: str) -> None:
    # Short episodes, so that every lane meets its limit at another step, over all thirty tasks of the family.
    limits = range(20, 50)
    tasks = [
        make(task, max_steps=limit).unwrapped.task
        for task, limit in zip(OF_A_FAMILY[family], limits, strict=True)
    ]
    batch, sync = make_vec(tasks, 30), SyncVectorEnv([lambda task=task: make(task) for task in tasks])
    seeds = list(range(100, 130))
    np.testing.assert_array_equal(batch.reset(seed=seeds)[0], sync.reset(seed=seeds)[0])
    for action in random_actions(120, 30):
        for mine, theirs in zip(batch.step(action)[:4], sync.step(action)[:4], strict=True):
            np.testing.assert_array_equal(mine, theirs)
            assert mine.dtype == theirs.dtype
    saved = zip(batch.call("save_state"), sync.call("save_state"), strict=True)
    assert all(mine["position"].tolist() == theirs["position"].tolist() for mine, theirs in saved)
    assert batch.call("task") == tuple(tasks)


def test_an_int_seed_is_spawned_and_none_goes_on() -> None:
    tasks = OF_A_FAMILY["state"][:2]
    one, other = make_vec(tasks, 4), make_vec(tasks, 4)
    first = one.reset(seed=9)[0]
    np.testing.assert_array_equal(first, other.reset(seed=9)[0])
    second = one.reset()[0]
    assert not np.array_equal(first, second)
    np.testing.assert_array_equal(second, other.reset()[0])
    assert len({tuple(row) for row in first.tolist()}) == 4


def test_a_mask_resets_some_lanes_and_leaves_the_others() -> None:
    batch = make_vec(OF_A_FAMILY["state"][0], 3)
    first = batch.reset(seed=1)[0]
    again = batch.reset(options={"reset_mask": np.array([False, True, False])})[0]
    assert (first == again).all(axis=1).tolist() == [True, False, True]


@pytest.mark.parametrize("family", FAMILIES)
def test_a_pickled_environment_is_a_fresh_one_of_the_same_task(family: str) -> None:
    env = make(OF_A_FAMILY[family][3])
    env.reset(seed=1)
    again = pickle.loads(pickle.dumps(env))  # noqa: S301
    assert again.unwrapped.task == env.unwrapped.task
    np.testing.assert_array_equal(again.reset(seed=2)[0], env.reset(seed=2)[0])
    for action in random_actions(20, 1)[:, 0]:
        mine, theirs = env.step(action), again.step(action)
        np.testing.assert_array_equal(mine[0], theirs[0])
        assert mine[1:] == theirs[1:]


@pytest.mark.parametrize("family", FAMILIES)
def test_a_saved_state_continues_bit_for_bit_elsewhere(family: str) -> None:
    task = OF_A_FAMILY[family][3]
    env, elsewhere, batch = make(task).unwrapped, make(task).unwrapped, make_vec(task, 3)
    actions = random_actions(60, 1)[:, 0]
    env.reset(seed=1)
    for action in actions[:30]:
        env.step(action)
    saved = env.save_state()
    assert {name: (value.dtype, value.shape) for name, value in saved.items()} == {
        "position": (np.float64, (2,)),
        "steps": (np.float64, ()),
    }
    assert saved["steps"] == 30
    elsewhere.reset(seed=2)
    elsewhere.restore_state(saved)
    batch.reset(seed=3)
    batch.restore_states({name: value[None] for name, value in saved.items()}, indices=[1])
    for action in actions[30:]:
        expected, got, rows = env.step(action), elsewhere.step(action), batch.step(np.tile(action, (3, 1)))
        np.testing.assert_array_equal(got[0], expected[0])
        np.testing.assert_array_equal(rows[0][1], expected[0])
        assert got[1:] == expected[1:]
        assert (rows[1][1], rows[2][1]) == expected[1:3]
    for name, value in env.save_state().items():
        assert elsewhere.save_state()[name].tolist() == value.tolist()
        assert batch.save_states()[name][1].tolist() == value.tolist()


def test_a_state_that_cannot_be_is_refused() -> None:
    task = OF_A_FAMILY["state"][3]
    env = make(task).unwrapped
    env.reset(seed=1)
    good = env.save_state()
    for bad, message in (
        ({"position": good["position"]}, "The state lacks 'steps'."),
        (good | {"velocity": np.zeros(2)}, "The state holds an unknown 'velocity'."),
        (good | {"position": np.zeros(3)}, "The state's 'position' has shape (3,), not (2,)."),
        (good | {"position": np.full(2, np.nan)}, "The state's 'position' holds a value that is not finite."),
        (good | {"position": np.full(2, 5.0)}, "The start (5, 5) lies in an obstacle or outside the map."),
    ):
        with pytest.raises(BenchError) as refused:
            env.restore_state(bad)
        assert str(refused.value).startswith(f"{task}: {message}")
    assert env.save_state()["position"].tolist() == good["position"].tolist()


@pytest.mark.parametrize("family", FAMILIES)
def test_declared_spaces_hold_100000_random_steps(family: str) -> None:
    lanes = 60
    batch = make_vec(OF_A_FAMILY[family], lanes)
    space = batch.single_observation_space
    observations, _ = batch.reset(seed=0)
    rewards = set()
    # Runs of one action press against walls and corners, which single random steps hardly do.
    for block in range(1700 // 10 + 1):
        action = random_actions(1, lanes, seed=block)[0]
        for _ in range(10):
            assert observations.dtype == space.dtype
            assert (observations >= space.low).all()
            assert (observations <= space.high).all()
            observations, reward, _, _, _ = batch.step(action)
            rewards |= set(reward.tolist())
    assert rewards <= {-1.0, -6.0, 9.0, 0.0}
    assert {-1.0, -6.0} < rewards


def test_lanes_of_two_families_are_refused() -> None:
    with pytest.raises(BenchError) as refused:
        make_vec([OF_A_FAMILY["state"][0], OF_A_FAMILY["image"][0]], 2)
    assert str(refused.value) == (
        "make_vec: The lanes observe differently: image, state. Give tasks of one navigation family."
    )


def test_a_body_variation_on_a_map_and_a_course_on_a_body_are_refused() -> None:
    with pytest.raises(BenchError) as refused:
        make("State-Based-Navigation-2d-Map0-Goal0", [Gravity(0.5)])
    assert refused.value.code == "bad-course"
    assert "there is also: Gravity(factor=0.5)." in str(refused.value)
    with pytest.raises(BenchError) as refused:
        make("Hopper", [Course("state", 0, 0)])
    assert str(refused.value) == (
        "Course(family='state', map=0, goal=0): A course on a map cannot be added to a body. "
        "Make a navigation task by its name."
    )


def test_a_misspelt_name_gets_a_hint() -> None:
    with pytest.raises(BenchError, match=r"Did you mean 'Image-Based-Navigation-2d-Map1-Goal2'\?"):
        make("Image-Based-Navigation-2dMap1-Goal2")
