"""gymnasium.make, gymnasium.make_vec and specs: what they accept, and what they return."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec

from gym_extensions.catalog.task import Task
from gym_extensions.envs import Gravity, RangeSensor, Wall, customize, make, make_vec
from gym_extensions.errors import BenchError

ID = "gym_extensions/HopperGravityHalf-v0"
MAP = "gym_extensions/State-Based-Navigation-2d-Map0-Goal0-v0"
FIXED = "A task's reward, body and time limit are fixed. For another task use gym_extensions.envs.customize."
CAMERA = (
    "It accepts render_mode, width, height, camera_id, camera_name, default_camera_config, max_geom, "
    "visual_options."
)
OTHER_LIMIT = f"{ID}: max_episode_steps is {{}}; the task has 1000. {FIXED}"

CHANGES: list[tuple[Callable[[], object], str]] = [
    (
        lambda: gym.make(ID, ctrl_cost_weight=100),
        f"{ID}: The task does not accept ctrl_cost_weight. {CAMERA} {FIXED}",
    ),
    (lambda: gym.make(ID, xml_file="a.xml"), f"{ID}: The task does not accept xml_file. {CAMERA} {FIXED}"),
    (
        lambda: gym.make_vec(ID, 2, healthy_reward=5.0),
        f"{ID}: The task does not accept healthy_reward. {CAMERA} {FIXED}",
    ),
    (
        lambda: gym.make(MAP, custom_arena=None),
        f"{MAP}: The task does not accept custom_arena. It accepts render_mode. {FIXED}",
    ),
    (lambda: gym.make(ID, max_episode_steps=50), OTHER_LIMIT.format(50)),
    (lambda: gym.make(ID, max_episode_steps=-1), OTHER_LIMIT.format(-1)),
    (lambda: gym.make_vec(ID, 2, max_episode_steps=50), OTHER_LIMIT.format(50)),
    (
        lambda: gym.make_vec(ID, 2, vectorization_mode="sync", max_episode_steps=50),
        OTHER_LIMIT.format(50),
    ),
    (lambda: gym.make(ID, task="Hopper"), f"{ID}: The keyword task is gym_extensions/Hopper-v0. {FIXED}"),
    (
        lambda: gym.make_vec(ID, 2, task="Hopper"),
        f"{ID}: The keyword task is gym_extensions/Hopper-v0. {FIXED}",
    ),
    (
        lambda: make(Task("HopperGravityHalf", "Hopper", (Gravity(0.1),))),
        f"{ID}: The task has the id of a published task and other content. Give it another name.",
    ),
    (
        lambda: gym.make_vec(ID, 2, render_mode="rgb_array"),
        f"{ID}: Environments that are stepped together do not render. "
        'Use vectorization_mode="sync", or make(task, render_mode=...).',
    ),
    (
        lambda: gym.make_vec(ID, 10**12),
        "make_vec: num_envs is 1000000000000. Give a whole number from 1 to 100000.",
    ),
]


@pytest.mark.parametrize(("change", "message"), CHANGES)
def test_a_published_id_accepts_no_other_task(change: Callable[[], object], message: str) -> None:
    with pytest.raises(BenchError) as caught:
        change()
    assert str(caught.value) == message


def test_a_published_id_accepts_rendering_and_its_own_time_limit() -> None:
    env = gym.make(
        ID, max_episode_steps=1000, width=64, height=48, camera_name="track", disable_env_checker=True
    )
    assert env.spec is not None and env.spec.max_episode_steps == 1000
    assert gym.make(MAP, render_mode="rgb_array").render_mode == "rgb_array"


def test_gymnasium_makes_the_render_modes_that_follow_from_others() -> None:
    for name in ("HopperGravityHalf", "State-Based-Navigation-2d-Map0-Goal0"):
        env = gym.make(f"gym_extensions/{name}-v0", render_mode="rgb_array_list")
        assert isinstance(env, gym.wrappers.RenderCollection)
        assert env.unwrapped.render_mode == "rgb_array"
        env.close()


def test_a_task_under_an_id_of_your_own_has_its_own_time_limit() -> None:
    spec = EnvSpec("Mine-v0", entry_point="gym_extensions.envs.make:construct", kwargs={"task": "Hopper"})
    assert gym.make(spec).get_wrapper_attr("task").name == "Hopper"
    spec.max_episode_steps = 50
    with pytest.raises(BenchError, match="max_episode_steps is 50; the task has 1000"):
        gym.make(spec)


@pytest.mark.parametrize("task_id", [ID, MAP])
def test_make_vec_of_gymnasium_returns_the_environments_that_are_stepped_together(task_id: str) -> None:
    env, ours = gym.make_vec(task_id, num_envs=3), make_vec(task_id, 3)
    assert type(env) is type(ours)
    assert env.spec is not None and env.spec.id == task_id
    singles = gym.make_vec(task_id, num_envs=3, vectorization_mode="sync")
    for other in (ours, singles):
        assert np.array_equal(env.reset(seed=4)[0], other.reset(seed=4)[0])
    assert type(gym.make_vec(task_id, num_envs=2, num_threads=2)) is type(ours)
    again = gym.make_vec(EnvSpec.from_json(env.spec.to_json()))
    assert again.num_envs == 3


CUSTOM: list[Task] = [
    customize("Hopper", [Gravity(0.8)], max_steps=77),
    customize("HalfCheetah", [RangeSensor(), Wall(nearest=2.0, farthest=3.0)]),
    customize(MAP, max_steps=20),
]


@pytest.mark.parametrize("task", CUSTOM, ids=[task.name for task in CUSTOM])
def test_the_spec_of_a_custom_task_survives_json(task: Task) -> None:
    env = make(task)
    assert env.spec is not None
    spec = EnvSpec.from_json(env.spec.to_json())
    again = gym.make(spec)
    assert again.get_wrapper_attr("task") == task
    assert again.spec is not None and again.spec.max_episode_steps == task.max_steps
    assert np.array_equal(again.reset(seed=1)[0], env.reset(seed=1)[0])
    many: Any = gym.make_vec(spec, num_envs=2)
    assert many.call("task") == (task, task)


def test_a_spec_with_an_unknown_variation_raises_an_error() -> None:
    env = make("Hopper", [Gravity(0.8)])
    assert env.spec is not None
    spec = EnvSpec.from_json(env.spec.to_json().replace('"Gravity"', '"Gravty"'))
    with pytest.raises(BenchError) as caught:
        gym.make(spec)
    assert str(caught.value) == "task: There is no variation 'Gravty'. Did you mean 'Gravity'?"
