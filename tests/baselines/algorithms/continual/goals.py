"""Tasks that cost microseconds: the reward of a step is −‖action − goal‖², with another goal per task."""

from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector.utils import batch_space

from gym_extensions.baselines import algorithms
from gym_extensions.baselines.agent import Array, Context, TaskLabel
from gym_extensions.baselines.algorithms.trpo import REFERENCE
from gym_extensions.baselines.trust_region.policy import Architecture
from gym_extensions.baselines.trust_region.values import ValueFit

OBSERVATIONS = gym.spaces.Box(-10, 10, (3,), np.float32)
ACTIONS = gym.spaces.Box(-1, 1, (2,), np.float32)
SMALL = replace(REFERENCE, hidden=(8, 8), value=ValueFit(hidden=(8,), epochs=2))
"""The settings of ``trpo`` with small networks."""
GOALS = np.array([[0.5, -0.5], [-0.5, 0.5], [0.8, 0.8]])


class Goals(gym.vector.VectorEnv[Any, Any, Any]):
    """Twenty environments of one task, or of the tasks in turn. Observations of task k have the mean k."""

    num_envs, batch_steps, num_tasks = 20, 400, len(GOALS)
    single_observation_space, single_action_space = OBSERVATIONS, ACTIONS
    observation_space, action_space = (batch_space(space, 20) for space in (OBSERVATIONS, ACTIONS))

    def __init__(self, *tasks: int) -> None:
        self.env_tasks = np.array([tasks[i % len(tasks)] for i in range(self.num_envs)])
        self.stage = tasks[0] + 1
        self._rng = np.random.default_rng(tasks[0])

    def reset(self, *, seed: Any = None, options: Any = None) -> tuple[Any, dict[str, Any]]:
        return self._observations(), {}

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        rewards = -np.sum((actions - GOALS[self.env_tasks]) ** 2, axis=1)
        ends = np.zeros(self.num_envs, bool)
        return self._observations(), rewards, ends, ends, {}

    def _observations(self) -> Array:
        noise = self._rng.standard_normal((self.num_envs, 3))
        observations: Array = (noise + self.env_tasks[:, None]).astype(np.float32)
        return observations


def make(name: str, seed: int = 0, **arguments: Any) -> Any:
    """An agent of that name."""
    factory: Any = algorithms.factory(name)
    return factory(OBSERVATIONS, ACTIONS, seed, SMALL, **arguments)


def learned(name: str, tasks: int, steps: int = 1_200, **arguments: Any) -> Any:
    """An agent that learned the first tasks in order."""
    agent = make(name, **arguments)
    for task in range(tasks):
        agent.learn(Goals(task), steps)
    return agent


def in_task(task: int) -> Context:
    """The context of an evaluation of the task."""
    return Context(np.zeros(1, bool), TaskLabel(f"goal-{task}", task))


LINE = Architecture((1, 1))
"""Mean w x + b; the parameters are w, b and log σ."""


def on_a_line(name: str, coefficient: float, *theta: float) -> Any:
    """An agent of that name whose policy is ``LINE`` with these parameters; nothing is stored."""
    agent = make(name, coefficient=coefficient)
    agent._architecture, agent._theta, agent._stored = LINE, np.array(theta), {}
    return agent


def end_task(agent: Any, theta: Array, observations: Array) -> None:
    """The end of a task with these parameters and sampled observations."""
    agent._theta = np.array(theta, float)
    agent._end_of_task(observations)
