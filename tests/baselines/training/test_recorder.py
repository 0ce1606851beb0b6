"""The recorder: what counts as a step, what is clipped, where the curve has points, what is refused."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from gym_extensions.baselines.training.recorder import Point, Recorder
from gym_extensions.catalog.budgets import budget
from gym_extensions.catalog.protocol import CURVE_POINTS
from gym_extensions.errors import BenchError


class Counting(gym.vector.VectorEnv[Any, Any, Any]):
    """Lanes whose episodes last ``lengths[lane]`` steps of reward 1; keeps the actions it was given."""

    def __init__(self, lengths: list[int]) -> None:
        self.num_envs, self.lengths = len(lengths), np.array(lengths)
        self.single_observation_space = gym.spaces.Box(-1, 1, (1,))
        self.single_action_space = gym.spaces.Box(-0.5, 0.5, (1,))
        self.metadata = {"autoreset_mode": gym.vector.AutoresetMode.NEXT_STEP}
        self.given: list[Any] = []
        self.seeds: list[Any] = []

    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        self.seeds.append(seed)
        mask = np.ones(self.num_envs, bool) if options is None else options["reset_mask"]
        if options is None:
            self.at, self.over = np.zeros(self.num_envs, int), np.zeros(self.num_envs, bool)
        self.at[mask], self.over[mask] = 0, False
        return np.zeros((self.num_envs, 1)), {}

    def step(self, actions: Any) -> Any:
        self.given.append(actions)
        self.at = np.where(self.over, 0, self.at + 1)
        rewards = np.where(self.over, 0.0, 1.0)
        self.over = self.at == self.lengths
        return np.zeros((self.num_envs, 1)), rewards, np.zeros(self.num_envs, bool), self.over.copy(), {}


def recorded(lengths: list[int], steps: int, *, batch: int = 10, tasks: tuple[str, ...] = ("a",)) -> Recorder:
    return Recorder(Counting(lengths), tasks, steps=steps, batch_steps=batch, seed=3)


def run(recorder: Recorder, vector_steps: int) -> None:
    recorder.reset()
    for _ in range(vector_steps):
        recorder.step(np.zeros((recorder.num_envs, 1)))


def test_the_step_that_resets_a_lane_counts_nothing():
    recorder = recorded([2, 5], steps=100)
    run(recorder, 6)
    # Lane 0: two steps, a reset, two steps, a reset. Lane 1: five steps, a reset.
    assert recorder.taken == 4 + 5


def test_actions_are_clipped_to_the_space_in_its_own_type():
    recorder = recorded([5, 5], steps=100)
    recorder.reset()
    recorder.step(np.array([[2.0], [-0.25]]))
    given = recorder.env.given[0]
    assert given.tolist() == [[0.5], [-0.25]]
    assert given.dtype == np.float32


def test_the_curve_has_the_mean_return_of_the_episodes_ended_since_the_last_point():
    recorder = recorded([2, 5], steps=100, batch=5)
    run(recorder, 6)
    recorder.flush()
    # Five steps are taken after the third row of actions: lane 0 has ended once (return 2). In the sixth row
    # lane 1 is reset; lane 0's second episode and lane 1's first have ended: (2 + 5) / 2.
    assert recorder.points == [Point("a", 5, 2.0), Point("a", 9, 3.5)]


def test_each_task_of_joint_training_has_its_own_points():
    recorder = recorded([2, 4, 2, 4], steps=100, batch=100, tasks=("a", "b"))
    run(recorder, 4)
    recorder.flush()
    assert recorder.points == [Point("a", 14, 2.0), Point("b", 14, 4.0)]


def test_episodes_of_a_thousand_steps_in_the_quick_budgets_lanes_give_a_long_enough_curve():
    plan = budget("100k")
    steps = plan.steps_for("halfcheetah-gravity")
    recorder = recorded([1000] * plan.num_envs, steps=steps, batch=plan.batch_steps)
    recorder.reset()
    while recorder.taken < steps:
        recorder.step(np.zeros((plan.num_envs, 1)))
    recorder.flush()
    assert len(recorder.points) >= CURVE_POINTS


def test_an_agent_may_exceed_its_budget_by_two_percent_and_no_more():
    recorder = recorded([1000], steps=100)
    run(recorder, 102)
    with pytest.raises(BenchError) as told:
        for _ in range(10):
            recorder.step(np.zeros((1, 1)))
    assert str(told.value) == (
        "learn: The agent took 103 training steps of a budget of 100. "
        "Stop after the steps that learn() is given; at most 2% more are allowed."
    )


def test_the_agent_does_not_choose_the_seeds_of_its_training():
    mine, other = recorded([5], steps=100), recorded([5], steps=100)
    mine.reset(seed=1)
    other.reset(seed=2)
    other.reset()
    assert mine.env.seeds[0] == other.env.seeds[0]
    assert other.env.seeds[1] != other.env.seeds[0]


def test_a_lane_that_is_reset_by_mask_takes_real_steps_at_once():
    recorder = recorded([2, 5], steps=100)
    run(recorder, 2)
    recorder.reset(options={"reset_mask": np.array([True, False])})
    recorder.step(np.zeros((2, 1)))
    assert recorder.taken == 6
