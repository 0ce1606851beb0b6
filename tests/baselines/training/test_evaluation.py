"""A cell of the matrix: one episode a lane, traces that replay, and nothing learned from being looked at."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gym_extensions.baselines.algorithms import trpo
from gym_extensions.baselines.algorithms.random import Random
from gym_extensions.baselines.training.evaluation import evaluate
from gym_extensions.baselines.training.recorder import Recorder
from gym_extensions.envs import make, make_vec
from gym_extensions.rollouts.traces import cut, trace_bytes

SEEDS = [11, 12, 13, 14]


def random_agent(env, seed=0):
    return Random(env.single_observation_space, env.single_action_space, seed)


def trained(steps: int, look: bool) -> np.ndarray:
    env, lanes = make_vec("Hopper", 2), make_vec("Hopper", 4)
    agent = trpo.make(env.single_observation_space, env.single_action_space, 5)
    for _ in range(2):
        agent.learn(Recorder(env, ["Hopper"], steps=steps, batch_steps=100, seed=1), steps)
        if look:
            evaluate(agent, lanes, SEEDS, 10)
    return agent._theta


def test_evaluation_changes_nothing_that_is_learned():
    assert np.array_equal(trained(300, look=True), trained(300, look=False))


def test_an_episode_is_the_single_environments_from_the_same_seed():
    lanes = make_vec("Hopper", 4)
    found = evaluate(random_agent(lanes), lanes, SEEDS, 10)
    env = make("Hopper")
    for seed, rollout in zip(SEEDS, found, strict=True):
        env.reset(seed=seed)
        outcomes = [env.step(action) for action in rollout.trace.actions]
        assert math.fsum(outcome[1] for outcome in outcomes) == rollout.return_
        assert [outcome[2] or outcome[3] for outcome in outcomes] == [False] * (rollout.length - 1) + [True]
        assert outcomes[-1][2] == rollout.terminated


def test_evaluated_again_from_the_same_seeds_it_is_the_same():
    lanes = make_vec("Hopper", 4)
    first, again = (evaluate(random_agent(lanes), lanes, SEEDS, 10) for _ in range(2))
    assert [trace_bytes(row.trace) for row in first] == [trace_bytes(row.trace) for row in again]


class Loud:
    """An agent whose actions leave the box."""

    def act(self, observations):
        return np.full((len(observations), 3), 7.5)

    def learn(self, env, steps):
        """Nothing."""


def test_actions_are_applied_and_recorded_inside_the_box():
    lanes = make_vec("Hopper", 2)
    trace = evaluate(Loud(), lanes, SEEDS[:2], 10)[0].trace
    assert trace.actions.dtype == np.float32
    assert (trace.actions == 1.0).all()


@pytest.mark.parametrize("task", ["Hopper", "HumanoidGravityHalf"])
def test_a_segment_replays_from_the_recorded_state_after_one_warm_up_step(task):
    lanes = make_vec(task, 4)
    rollout = max(evaluate(random_agent(lanes), lanes, SEEDS, 5), key=lambda row: row.length)
    trace, env = rollout.trace, make(task)
    assert len(trace.segment_returns) == math.ceil(rollout.length / 5) > 2
    assert math.fsum(trace.segment_returns) == pytest.approx(rollout.return_, abs=1e-12)
    env.reset(seed=0)
    for segment in range(1, len(trace.segment_returns)):
        env.unwrapped.restore_state({name: rows[segment - 1] for name, rows in trace.states.items()})
        env.step(trace.actions[5 * segment - 1])
        rewards = [env.step(action)[1] for action in trace.actions[5 * segment : 5 * segment + 5]]
        assert math.fsum(rewards) == pytest.approx(trace.segment_returns[segment], abs=1e-12)


CUTS = [
    # steps, K, segments, states kept: one less than segments, whatever was recorded beyond.
    (1, 10, 1),
    (10, 10, 1),
    (11, 10, 2),
    (20, 10, 2),
    (21, 10, 3),
]


@pytest.mark.parametrize(("steps", "size", "segments"), CUTS)
def test_a_trace_has_a_state_for_every_segment_but_the_first(steps, size, segments):
    states = [{"qpos": np.array([float(t)]), "derived_x": np.zeros(2)} for t in range(size - 1, 40, size)]
    trace = cut(np.zeros((steps, 1)), np.ones(steps), states, size)
    assert len(trace.segment_returns) == segments
    assert sum(trace.segment_returns) == steps
    assert trace.states.keys() <= {"qpos"}
    if segments > 1:
        assert trace.states["qpos"].ravel().tolist() == [size * k - 1 for k in range(1, segments)]
