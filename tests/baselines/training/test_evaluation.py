"""Evaluation: one episode per environment, what an agent is given, and no effect on learning."""

from typing import Any

import numpy as np

from gym_extensions.baselines import Context
from gym_extensions.baselines.agent import TaskLabel
from gym_extensions.baselines.training.runner import evaluate
from gym_extensions.envs import make_vec

from .test_environment import Counting

SEEDS = [11, 12, 13, 14]


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
