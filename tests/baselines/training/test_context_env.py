"""The environment of ``learn`` shows the tasks and the stage to agents that ask for them, and to no other."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.wrappers.vector import NormalizeObservation, RecordEpisodeStatistics

from gym_extensions.baselines.agent import Observes
from gym_extensions.baselines.training.recorder import Recorder, TrainingContext
from gym_extensions.envs import VectorTaskId, group, make_vec
from gym_extensions.errors import BenchError

GROUP = group("hopper-gravity")
EVERYTHING = Observes(True, True, True)
NEEDS = {
    "task_ids": "task_in_training",
    "env_task_ids": "task_in_training",
    "env_tasks": "task_in_training",
    "stage": "boundaries",
    "num_tasks": "boundaries",
}


def training(observes: Observes, trained: slice = slice(2, 4), num_envs: int = 4, stage: int = 3) -> Recorder:
    """A recorder of the tasks in the slice of hopper-gravity."""
    tasks = GROUP.tasks[trained]
    context = TrainingContext(observes, GROUP.task_ids, stage)
    ids = [task.id for task in tasks]
    return Recorder(make_vec(tasks, num_envs), ids, steps=400, batch_steps=50, seed=0, context=context)


def test_an_agent_that_asks_for_everything_reads_the_tasks_and_the_stage() -> None:
    env, (first, second) = training(EVERYTHING), GROUP.task_ids[2:4]
    assert env.task_ids == (first, second)
    assert env.env_task_ids == (first, second, first, second)
    assert env.env_tasks.tolist() == [2, 3, 2, 3]
    assert (env.stage, env.num_tasks) == (3, 5)


def test_every_agent_reads_the_budget_and_the_batch_size() -> None:
    env = training(Observes())
    assert (env.budget_steps, env.batch_steps) == (400, 50)


@pytest.mark.parametrize(("name", "needed"), NEEDS.items())
def test_an_attribute_that_was_not_asked_for_is_refused(name: str, needed: str) -> None:
    env = training(Observes(**{field: field != needed for field in NEEDS.values()}))
    with pytest.raises(BenchError) as error:
        getattr(env, name)
    assert error.value.code == "not-requested"
    assert not hasattr(env, name)
    assert getattr(env, name, None) is None


@pytest.mark.parametrize("method", ["call", "get_attr"])
def test_a_call_that_shows_the_task_is_refused(method: str) -> None:
    with pytest.raises(BenchError, match=r"^env\.call\('task'\): .* observes\.task_in_training\."):
        getattr(training(Observes(task_in_evaluation=True, boundaries=True)), method)("task")


def test_calls_return_what_the_wrapped_environment_returns() -> None:
    env = training(Observes(task_in_training=True))
    env.reset()
    assert env.call("task") == env.get_attr("task") == GROUP.tasks[2:4] * 2
    assert env.get_attr("np_random_seed") == env.env.call("np_random_seed")  # type: ignore[attr-defined]


def test_the_unwrapped_environment_and_the_spec_do_not_show_the_task() -> None:
    env = training(Observes())
    env.env.spec = gym.spec("CartPole-v1")
    assert env.unwrapped is env
    assert env.spec is None
    assert training(EVERYTHING).spec is None
    asking = training(EVERYTHING)
    asking.env.spec = env.env.spec
    assert asking.spec is env.env.spec


def test_the_wrapper_that_appends_the_task_works_in_training() -> None:
    env = VectorTaskId(training(Observes(task_in_training=True)), GROUP)
    observations, _ = env.reset()
    assert observations[:, -5:].argmax(axis=1).tolist() == [2, 3, 2, 3]
    assert env.step(env.action_space.sample())[0].shape == (4, 16)


def test_gymnasiums_wrappers_work_for_an_agent_that_asks_for_nothing() -> None:
    env: Any = NormalizeObservation(RecordEpisodeStatistics(training(Observes())))
    env.reset()
    env.step(env.action_space.sample())
    assert (env.num_envs, str(env)[:22]) == (4, "<NormalizeObservation,")
    assert {name: value for name, value in vars(env.env.env).items() if name in NEEDS} == {}


def test_the_spaces_and_the_generator_follow_from_the_runs_seed() -> None:
    first, second = training(Observes()), training(Observes())
    for name in ("action_space", "single_action_space", "observation_space", "single_observation_space"):
        samples = [getattr(env, name).sample() for env in (first, second)]
        assert np.array_equal(*samples)
    assert first.np_random.random() == second.np_random.random()
