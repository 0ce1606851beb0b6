"""The recorder counts transitions, clips actions, records the curve and enforces the budget."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from gym_extensions.baselines.training.recorder import Point, Recorder
from gym_extensions.catalog.protocol import CURVE_POINTS, budget
from gym_extensions.errors import BenchError


class Counting(gym.vector.VectorEnv[Any, Any, Any]):
    """Environments with episodes of ``lengths[i]`` steps of reward 1. Stores actions and seeds."""

    def __init__(self, lengths: list[int]) -> None:
        self.num_envs, self.lengths = len(lengths), np.array(lengths)
        self.single_observation_space = gym.spaces.Box(-1, 1, (1,))
        self.single_action_space = gym.spaces.Box(-0.5, 0.5, (1,))
        self.observation_space = gym.vector.utils.batch_space(self.single_observation_space, self.num_envs)
        self.action_space = gym.vector.utils.batch_space(self.single_action_space, self.num_envs)
        self.metadata = {"autoreset_mode": gym.vector.AutoresetMode.NEXT_STEP}
        self.received: list[Any] = []
        self.seeds: list[Any] = []

    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        self.seeds.append(seed)
        mask = np.ones(self.num_envs, bool) if options is None else options["reset_mask"]
        if options is None:
            self.at, self.over = np.zeros(self.num_envs, int), np.zeros(self.num_envs, bool)
        self.at[mask], self.over[mask] = 0, False
        return np.zeros((self.num_envs, 1)), {}

    def step(self, actions: Any) -> Any:
        self.received.append(actions)
        self.at = np.where(self.over, 0, self.at + 1)
        rewards = np.where(self.over, 0.0, 1.0)
        self.over = self.at == self.lengths
        return np.zeros((self.num_envs, 1)), rewards, np.zeros(self.num_envs, bool), self.over.copy(), {}


def recorded(lengths: list[int], steps: int, *, batch: int = 10, tasks: tuple[str, ...] = ("a",)) -> Recorder:
    return Recorder(Counting(lengths), tasks, steps=steps, batch_steps=batch, seed=3)


def received_by(recorder: Recorder) -> Counting:
    assert isinstance(recorder.env, Counting)
    return recorder.env


def run(recorder: Recorder, vector_steps: int) -> None:
    recorder.reset()
    for _ in range(vector_steps):
        recorder.step(np.zeros((recorder.num_envs, 1)))


def test_the_step_that_resets_an_environment_is_not_counted() -> None:
    recorder = recorded([2, 5], steps=100)
    run(recorder, 6)
    # Environment 0: two steps, a reset, two steps, a reset. Environment 1: five steps, a reset.
    assert recorder.taken == 4 + 5


def test_actions_are_clipped_and_cast_to_the_dtype_of_the_action_space() -> None:
    recorder = recorded([5, 5], steps=100)
    recorder.reset()
    recorder.step(np.array([[2.0], [-0.25]]))
    received = received_by(recorder).received[0]
    assert received.tolist() == [[0.5], [-0.25]]
    assert received.dtype == np.float32


def test_a_point_is_the_mean_return_of_the_episodes_that_ended_since_the_last_point() -> None:
    recorder = recorded([2, 5], steps=100, batch=5)
    run(recorder, 6)
    recorder.flush()
    # Five steps are taken after the third row of actions: environment 0 has ended once (return 2). In the
    # sixth row environment 1 is reset; its first and the other's second episode have ended: (2 + 5) / 2.
    assert recorder.points == [Point("a", 5, 2.0), Point("a", 9, 3.5)]


def test_each_task_of_joint_training_has_its_own_points() -> None:
    recorder = recorded([2, 4, 2, 4], steps=100, batch=100, tasks=("a", "b"))
    run(recorder, 4)
    recorder.flush()
    assert recorder.points == [Point("a", 14, 2.0), Point("b", 14, 4.0)]


def test_the_100k_budget_gives_enough_points_for_episodes_of_1000_steps() -> None:
    plan = budget("100k")
    steps = plan.steps_for("halfcheetah-gravity")
    recorder = recorded([1000] * plan.num_envs, steps=steps, batch=plan.batch_steps)
    recorder.reset()
    while recorder.taken < steps:
        recorder.step(np.zeros((plan.num_envs, 1)))
    recorder.flush()
    assert len(recorder.points) >= CURVE_POINTS


def test_an_agent_may_exceed_its_budget_by_two_percent() -> None:
    recorder = recorded([1000], steps=100)
    run(recorder, 102)
    with pytest.raises(BenchError) as error:
        for _ in range(10):
            recorder.step(np.zeros((1, 1)))
    assert error.value.code == "budget-exceeded"


def test_the_agent_cannot_choose_the_seeds_of_its_training() -> None:
    mine, other = recorded([5], steps=100), recorded([5], steps=100)
    mine.reset(seed=1)
    other.reset(seed=2)
    other.reset()
    seeds = received_by(other).seeds
    assert received_by(mine).seeds[0] == seeds[0]
    assert seeds[1] != seeds[0]


def test_an_environment_that_is_reset_by_mask_takes_transitions_at_once() -> None:
    recorder = recorded([2, 5], steps=100)
    run(recorder, 2)
    recorder.reset(options={"reset_mask": np.array([True, False])})
    recorder.step(np.zeros((2, 1)))
    assert recorder.taken == 6
