"""Small policies of two observations and one action."""

from __future__ import annotations

import numpy as np

from gym_extensions.rollouts.policies import Policy

SEEN = np.random.default_rng(0).standard_normal((40, 2))
SMALL = Policy(
    action_offset=np.zeros(1, np.float32),
    action_scale=np.ones(1, np.float32),
    weights=(np.array([[0.5, -1.0, 2.0], [1.0, 0.0, 0.5]], np.float32), np.ones((3, 1), np.float32)),
    biases=(np.zeros(3, np.float32), np.full(1, 0.125, np.float32)),
    activation="tanh",
    log_sigma=np.full(1, -1.0, np.float32),
)
TASKED = Policy(
    action_offset=np.zeros(1),
    action_scale=np.ones(1),
    weights=(np.array([[[1.0], [1.0]], [[1.0], [-1.0]]]),),
    biases=(np.zeros(1),),
    masks=(np.array([[[True], [True]], [[True], [False]]]),),
)
"""Two rows of tasks: the sum of the observations, and the first of them."""
