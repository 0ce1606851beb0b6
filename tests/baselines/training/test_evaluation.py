"""Evaluation: one episode per environment, traces that replay, and no effect on learning."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from gym_extensions.baselines import Context
from gym_extensions.baselines.algorithms import trpo
from gym_extensions.baselines.algorithms.random import Random
from gym_extensions.baselines.context import TaskLabel
from gym_extensions.baselines.training.evaluation import evaluate
from gym_extensions.baselines.training.recorder import Recorder
from gym_extensions.envs import make, make_vec
from gym_extensions.rollouts.traces import cut, trace_bytes

from .test_recorder import Counting

SEEDS = [11, 12, 13, 14]


def random_agent(env: Any, seed: int = 0) -> Random:
    return Random(env.single_observation_space, env.single_action_space, seed)


def trained_parameters(steps: int, with_evaluation: bool) -> Any:
    env: Any = make_vec("Hopper", 2)
    evaluation_env = make_vec("Hopper", 4)
    agent = trpo.make(env.single_observation_space, env.single_action_space, 5)
    for _ in range(2):
        agent.learn(Recorder(env, ["Hopper"], steps=steps, batch_steps=100, seed=1), steps)
        if with_evaluation:
            evaluate(agent, evaluation_env, SEEDS, 10)
    return agent._theta


def test_evaluation_does_not_change_what_is_learned() -> None:
    assert np.array_equal(trained_parameters(300, True), trained_parameters(300, False))


def test_an_episode_equals_that_of_the_single_environment_with_the_same_seed() -> None:
    envs = make_vec("Hopper", 4)
    rollouts = evaluate(random_agent(envs), envs, SEEDS, 10)
    env = make("Hopper")
    for seed, rollout in zip(SEEDS, rollouts, strict=True):
        assert rollout.trace is not None
        env.reset(seed=seed)
        outcomes = [env.step(action) for action in rollout.trace.actions]
        assert math.fsum(outcome[1] for outcome in outcomes) == rollout.return_
        assert [outcome[2] or outcome[3] for outcome in outcomes] == [False] * (rollout.length - 1) + [True]
        assert outcomes[-1][2] == rollout.terminated


def test_evaluation_with_the_same_seeds_gives_the_same_traces() -> None:
    envs = make_vec("Hopper", 4)
    first, second = (
        [trace_bytes(row.trace) for row in evaluate(random_agent(envs), envs, SEEDS, 10) if row.trace]
        for _ in range(2)
    )
    assert first == second
    assert len(first) == 4


class Loud:
    """An agent whose actions are outside the action space."""

    def act(self, observations: Any) -> Any:
        return np.full((len(observations), 3), 7.5)

    def learn(self, env: Any, steps: int) -> None:
        """Does nothing."""


def test_actions_are_applied_and_recorded_inside_the_action_space() -> None:
    envs = make_vec("Hopper", 2)
    trace = evaluate(Loud(), envs, SEEDS[:2], 10)[0].trace
    assert trace is not None
    assert trace.actions.dtype == np.float32
    assert (trace.actions == 1.0).all()


@pytest.mark.parametrize("task", ["Hopper", "HumanoidGravityHalf"])
def test_a_segment_replays_from_its_recorded_state_after_one_warm_up_step(task: str) -> None:
    envs = make_vec(task, 4)
    rollout = max(evaluate(random_agent(envs), envs, SEEDS, 5), key=lambda row: row.length)
    trace, env = rollout.trace, make(task)
    assert trace is not None
    assert len(trace.segment_returns) == math.ceil(rollout.length / 5) > 2
    assert math.fsum(trace.segment_returns) == pytest.approx(rollout.return_, abs=1e-12)
    env.reset(seed=0)
    for segment in range(1, len(trace.segment_returns)):
        unwrapped: Any = env.unwrapped
        unwrapped.restore_state({name: rows[segment - 1] for name, rows in trace.states.items()})
        env.step(trace.actions[5 * segment - 1])
        rewards = [float(env.step(action)[1]) for action in trace.actions[5 * segment : 5 * segment + 5]]
        assert math.fsum(rewards) == pytest.approx(trace.segment_returns[segment], abs=1e-12)


class Listening:
    """An agent that stores the context of each call."""

    def __init__(self, num_actions: int) -> None:
        self.num_actions, self.contexts = num_actions, list[Context]()

    def act(self, observations: Any, context: Context) -> Any:
        self.contexts.append(context)
        return np.ones((len(observations), self.num_actions))

    def learn(self, env: Any, steps: int) -> None:
        """Does nothing."""


def test_an_episode_starts_at_the_first_step_and_after_each_autoreset() -> None:
    agent = Listening(1)
    evaluate(agent, Counting([2, 5]), SEEDS[:2])
    starts = np.array([context.episode_starts for context in agent.contexts]).T
    # The first environment's third observation is the last one of its episode. The step from there resets it.
    assert starts.tolist() == [[True, False, False, True, False], [True, False, False, False, False]]


def test_the_context_has_the_task_only_if_it_is_passed() -> None:
    agent, envs = Listening(3), make_vec("Hopper", 2)
    evaluate(agent, envs, SEEDS[:2])
    assert not hasattr(agent.contexts[0], "task")
    evaluate(agent, envs, SEEDS[:2], label=TaskLabel("gym_extensions/Hopper-v0", 2))
    assert (agent.contexts[-1].task_id, agent.contexts[-1].task) == ("gym_extensions/Hopper-v0", 2)


CUTS = [
    # steps, K, segments; there is one state less than segments, even if more were recorded
    (1, 10, 1),
    (10, 10, 1),
    (11, 10, 2),
    (20, 10, 2),
    (21, 10, 3),
]


@pytest.mark.parametrize(("steps", "size", "segments"), CUTS)
def test_a_trace_has_a_state_for_every_segment_but_the_first(steps: int, size: int, segments: int) -> None:
    states = [{"qpos": np.array([float(t)]), "derived_x": np.zeros(2)} for t in range(size - 1, 40, size)]
    trace = cut(np.zeros((steps, 1)), np.ones(steps), states, size)
    assert len(trace.segment_returns) == segments
    assert sum(trace.segment_returns) == steps
    assert trace.states.keys() <= {"qpos"}
    if segments > 1:
        assert trace.states["qpos"].ravel().tolist() == [size * k - 1 for k in range(1, segments)]
