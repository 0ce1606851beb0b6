"""make and gymnasium.make: every task, what a published id accepts, specs, and mistakes."""

import subprocess
import sys
import warnings
from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.utils.env_checker import check_env

from gym_extensions.catalog.tasks import TASKS, Task, customize, task
from gym_extensions.catalog.variations import Course
from gym_extensions.envs import Gravity, MovingGoal, RangeSensor, SensorNoise, Wall, make, make_vec
from gym_extensions.envs.make import construct
from gym_extensions.errors import BenchError

from ..conftest import refused
from .mujoco.test_env import KINDS

ID = "gym_extensions/HopperGravityHalf-v0"
MAP = "gym_extensions/State-Based-Navigation-2d-Map0-Goal0-v0"


@pytest.mark.parametrize("task_id", [ids[-1] for ids in KINDS.values()], ids=list(KINDS))
def test_a_task_of_each_kind_passes_gymnasiums_checker(task_id: str) -> None:
    env = gym.make(task_id)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # Gymnasium's own bodies have unbounded observations and asymmetric actions too.
        warnings.filterwarnings("ignore", message=".*Box (observation|action) space.*")
        warnings.filterwarnings("ignore", message=".*For Box action spaces.*")
        check_env(env.unwrapped, skip_render_check=True)
    assert env.spec is not None and env.spec.max_episode_steps == TASKS[task_id].max_steps
    assert env.get_wrapper_attr("task") == TASKS[task_id]


@pytest.mark.parametrize(
    "call",
    [
        lambda **keyword: gym.make(ID, **keyword),
        lambda **keyword: gym.make(MAP, **keyword),
        lambda **keyword: gym.make_vec(ID, 2, **keyword),
        lambda **keyword: gym.make_vec(ID, 2, vectorization_mode="sync", **keyword),
    ],
)
@pytest.mark.parametrize("keyword", ["frameskip", "ctrl_cost_weight", "xml_file", "custom_arena"])
def test_a_keyword_that_no_published_id_takes_is_an_error(call: Callable[..., Any], keyword: str) -> None:
    with pytest.raises(TypeError, match=f"unexpected keyword argument '{keyword}'"):
        call(**{keyword: 1})


def test_no_keyword_makes_another_task_under_a_published_id() -> None:
    for make_one in (gym.make, gym.make_vec):
        with pytest.raises(TypeError):
            make_one(ID, task="Hopper")
    with refused("changed-task", where=ID):
        make(Task("HopperGravityHalf", "Hopper", (Gravity(0.1),)))


@pytest.mark.parametrize(
    ("keywords", "code"),
    [({"max_episode_steps": 50}, "changed-task"), ({"render_mode": "rgb_array"}, "no-rendering")],
)
def test_environments_stepped_together_have_their_limit_and_no_pictures(keywords: Any, code: str) -> None:
    with refused(code, where=ID):
        gym.make_vec(ID, 2, **keywords)


def test_ids_are_found_by_the_prefix_form() -> None:
    code = "import gymnasium as gym; print(gym.make('gym_extensions.envs:{}').spec.id)"
    process = subprocess.run([sys.executable, "-c", code.format(ID)], capture_output=True, check=True)
    assert process.stdout.decode().strip() == ID


def test_a_published_id_accepts_rendering() -> None:
    env = gym.make(ID, width=64, height=48, camera_name="track", disable_env_checker=True)
    assert env.spec is not None and env.spec.max_episode_steps == 1000
    for name in (ID, MAP):
        listed = gym.make(name, render_mode="rgb_array_list")
        assert isinstance(listed, gym.wrappers.RenderCollection)
        assert listed.unwrapped.render_mode == "rgb_array"
        listed.close()


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


def broken_spec() -> object:
    spec = make("Hopper", [Gravity(0.8)]).spec
    assert spec is not None
    return gym.make(EnvSpec.from_json(spec.to_json().replace('"Gravity"', '"Gravty"')))


def step(action: Any, name: str = "HopperGravityHalf") -> object:
    env = make(name)
    env.reset(seed=0)
    return env.step(action)


MISTAKES: list[tuple[Callable[[], object], str, str]] = [
    (broken_spec, "unknown-variation", "Did you mean 'Gravity'?"),
    (lambda: make("HopperGravtyHalf"), "unknown-task", "Did you mean 'HopperGravityHalf'?"),
    (lambda: make("gym_extensions/hopper-v0"), "unknown-task", "'gym_extensions/Hopper-v0'?"),
    (lambda: make(None), "unknown-task", "There is no task 'None'"),  # type: ignore[arg-type]
    (lambda: make("HopperGravityHalf-v0"), "unknown-task", "Did you mean 'HopperGravityHalf'?"),
    (lambda: make_vec("Pendulum", 1), "unknown-task", "such as Pendulum-v1"),
    (lambda: make(Task("Mine", "Hoper")), "unknown-base", "Did you mean 'Hopper'?"),
    (lambda: make("Hopper", Gravity(0.5)), "no-list", "Give a list"),  # type: ignore[arg-type]
    (lambda: make("Hopper", ["Gravity"]), "no-variation", "'Gravity'"),  # type: ignore[list-item]
    (lambda: make("Pusher", [Gravity(0.5)]), "misplaced-variation", "It fits Hopper, Walker2d"),
    (lambda: make("Hopper", [MovingGoal()]), "misplaced-variation", "It fits Pusher."),
    (lambda: make_vec(customize("Pusher", [RangeSensor()]), 2), "misplaced-variation", "It fits Hopper"),
    (lambda: make("HopperWall", [Wall()]), "repeated-variation", "Give it once."),
    (lambda: make("Hopper", [SensorNoise()]), "missing-variation", ""),
    (lambda: make(MAP, [Gravity(0.5)]), "bad-course", "no other variation; it has [Course("),
    (lambda: make("Hopper", [Course("state", 0, 0)]), "misplaced-variation", "It fits Navigation."),
    *(
        (lambda steps=steps: make("Hopper", max_steps=steps), "bad-limit", repr(steps))
        for steps in (0, -3, 2.5, True, "10")
    ),
    (lambda: step(np.zeros(4)), "bad-action", "shape (4,). Give numbers of the shape (3,)"),
    (lambda: step(0.5), "bad-action", "shape ()"),
    (lambda: step(np.array([0, np.nan, 0])), "bad-action", "action[1] is nan"),
    (lambda: step(["a", "b", "c"]), "bad-action", "dtype <U1"),
    (lambda: step([[0], [0, 1], 0]), "bad-action", "differ in shape"),
    (lambda: step([True, False, True]), "bad-action", "dtype bool"),
    (lambda: step(np.array([np.nan, 0]), MAP), "bad-action", "action[0] is nan"),
]


@pytest.mark.parametrize(("mistake", "code", "fact"), MISTAKES)
def test_a_mistake_is_named(mistake: Callable[[], object], code: str, fact: str) -> None:
    with refused(code, fact):
        mistake()


@pytest.mark.parametrize("name", ["Hopper", "State-Based-Navigation-2d-Map0-Goal0"])
def test_an_environment_needs_a_reset_first(name: str) -> None:
    env: Any = construct(name)
    with pytest.raises(gym.error.ResetNeeded) as caught:
        env.step(env.action_space.sample())
    assert isinstance(caught.value, BenchError) and caught.value.where == task(name).id
