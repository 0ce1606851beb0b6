"""The two TRPO agents: acting, learning, saving, and agreement with the committed submission."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from gym_extensions.baselines import algorithms
from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.algorithms import trpo
from gym_extensions.baselines.algorithms.trpo import REFERENCE
from gym_extensions.baselines.generators import training_seed
from gym_extensions.baselines.training.environment import Report, TrainingEnv
from gym_extensions.catalog.groups import group
from gym_extensions.catalog.protocol import budget
from gym_extensions.envs import make_vec
from gym_extensions.submissions.run import read_run

BOX = gym.spaces.Box(-1, 1, (3,), np.float32)
WIDE = gym.spaces.Box(-2, 2, (2,), np.float32)
SUBMISSION = Path(__file__).parents[3] / "submissions/trpo-2017/hopper-gravity/sequential/run0.json"


class Corridor(gym.vector.VectorEnv[Any, Any, Any]):
    """Ten environments of reward 1 per step, whose episodes end after five steps, by failure or by time.

    Before a failure the observation counts the steps; before the time limit it is noise.
    """

    num_envs, length = 10, 5
    single_observation_space = BOX
    single_action_space = gym.spaces.Box(-1, 1, (1,), np.float32)

    def __init__(self, ends: bool, batch_steps: int = 2_000) -> None:
        self._ends, self._step, self.batch_steps = ends, 0, batch_steps
        self._rng = np.random.default_rng(0)

    def reset(self, *, seed: Any = None, options: Any = None) -> tuple[Any, dict[str, Any]]:
        self._step = 0
        return self._observations(), {}

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        self._step = (self._step + 1) % (self.length + 1)  # The step after an episode's end resets.
        over = np.full(self.num_envs, self._step == self.length)
        reward = np.full(self.num_envs, float(self._step > 0))
        return self._observations(), reward, over & self._ends, over & ~np.array(self._ends), {}

    def _observations(self) -> Array:
        if not self._ends:
            return self._rng.standard_normal((self.num_envs, 3), np.float32)
        return np.full((self.num_envs, 3), self._step, np.float32)


@pytest.mark.parametrize(
    ("ends", "expected"),
    [
        (False, [10, 10, 10, 10, 10]),  # 1 / (1 − .9): a time limit is not the end.
        (True, [4.0951, 3.439, 2.71, 1.9, 1.0]),  # 1, 1 + .9, 1 + .9 + .81, … to the failure.
    ],
    ids=["time limit", "failure"],
)
def test_a_time_limit_is_bootstrapped_and_a_failure_is_not(ends: bool, expected: list[float]) -> None:
    agent = trpo.Trpo(BOX, Corridor.single_action_space, 0, replace(REFERENCE, discount=0.9))
    agent.learn(Corridor(ends, batch_steps=500), 15_000)
    states = np.arange(5, dtype=np.float32)[:, None].repeat(3, axis=1) / (1 if ends else 4)
    np.testing.assert_allclose(agent._value.predict(states), expected, atol=0.5)


@pytest.mark.parametrize(("steps", "taken"), [(10, 10), (12, 20)])
def test_a_vector_step_can_be_longer_than_several_batches(steps: int, taken: int) -> None:
    agent = trpo.make(BOX, Corridor.single_action_space, 0)
    agent.learn(Corridor(ends=True, batch_steps=3), steps)
    assert agent._moments.count == taken


def test_trpo_acts_with_its_mean_and_explores_with_its_sigma_and_trpo_2017_samples() -> None:
    observations = np.zeros((4000, 3), np.float32)
    mean = trpo.make(BOX, WIDE, 0).act(observations)
    sampled = trpo.Trpo2017(BOX, WIDE, 0).act(observations)
    assert np.array_equal(mean, np.broadcast_to(mean[0], mean.shape))
    # σ is half the width of the box.
    np.testing.assert_allclose(sampled.std(axis=0), [2, 2], rtol=0.06)
    np.testing.assert_allclose(sampled.mean(axis=0), 0, atol=0.15)
    explored = trpo.make(BOX, WIDE, 0)._explore(observations)
    np.testing.assert_allclose(explored.std(axis=0), np.exp(REFERENCE.initial_log_sigma), rtol=0.06)


@pytest.mark.committed
def test_trpo_2017_learns_as_in_the_committed_submission() -> None:
    """The first batch of run 0 and, after an update, the second.

    The bits of an update depend on the processor. Hopper amplifies them, so later batches are not compared.
    """
    tasks = group("hopper-gravity")
    first, plan = tasks.tasks[0], budget("100k")
    seed = training_seed(0, tasks.id, first.id, "training")
    env = make_vec(first, plan.num_envs)
    batches: list[Report] = []
    settings: Any = {"steps": 10**6, "batch_steps": plan.batch_steps, "report": batches.append}
    recorder = TrainingEnv(env, [first.id], seed=seed, **settings)
    spaces = recorder.single_observation_space, recorder.single_action_space
    agent = algorithms.factory("trpo-2017")(*spaces, training_seed(0, tasks.id, "agent"))
    agent.learn(recorder, 2 * plan.batch_steps)
    curve = read_run(SUBMISSION).curves[0]
    for batch, step, value, tolerance in zip(batches, curve.steps, curve.returns, (1e-6, 2e-2), strict=False):
        np.testing.assert_allclose((batch.step, batch.returns[first.id]), (step, value), rtol=tolerance)
    assert len(batches) >= 2


def test_the_page_that_walks_through_an_update_names_functions_of_its_files() -> None:
    page = Path(__file__).resolve().parents[3] / "docs/one-update.md"
    named = re.findall(r"\[`(?:\w+\.)?(\w+)`\]\((\S+\.py)\)", page.read_text(encoding="utf-8"))
    assert len(named) > 20
    for name, file in named:
        code = (page.parent / file).read_text(encoding="utf-8")
        assert re.search(rf"^ *(def|class) {name}\b", code, re.MULTILINE), (name, file)
