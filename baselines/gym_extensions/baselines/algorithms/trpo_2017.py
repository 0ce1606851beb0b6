"""TRPO with the settings of Henderson et al. (2017), evaluated by sampled actions as in the paper.

It differs from the paper's in the value function: a small MLP in place of rllab's linear baseline.
"""

from __future__ import annotations

import gymnasium as gym

from gym_extensions.baselines.algorithms.trpo import Trpo
from gym_extensions.baselines.trpo.settings import HENDERSON_2017


class Trpo2017(Trpo):
    """The agent with the paper's settings."""

    name, title = "trpo-2017", "TRPO (2017 settings)"
    description = "TRPO with the paper's settings; an MLP value function in place of rllab's linear baseline."
    tuning_steps = 0
    tuning_tasks = ()

    def __init__(self, observation_space: gym.spaces.Box, action_space: gym.spaces.Box, seed: int) -> None:
        super().__init__(observation_space, action_space, seed, HENDERSON_2017)


make = Trpo2017
