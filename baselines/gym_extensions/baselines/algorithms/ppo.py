"""PPO of Stable-Baselines3, with observations standardized by statistics that persist across tasks."""

import math
from typing import Any

from stable_baselines3 import PPO

from gym_extensions.baselines.adapters.sb3 import Sb3Factory
from gym_extensions.baselines.agent import Card
from gym_extensions.baselines.algorithms.additions import with_addition

SETTINGS: dict[str, Any] = {
    "learning_rate": 3e-4,  # Schulman et al. 2017, table 3
    "n_epochs": 10,  # the same
    "batch_size": 512,  # this project: minibatches of 64 take three times as long per batch of 2,000
    "gamma": 0.99,  # Schulman et al. 2017, table 3
    "gae_lambda": 0.95,  # the same
    "clip_range": 0.2,  # Schulman et al. 2017, table 1
    "ent_coef": 0.0,  # Schulman et al. 2017, section 6.1
    "vf_coef": 0.5,  # the default of Stable-Baselines3
    "max_grad_norm": 0.5,  # the same
    "policy_kwargs": {
        "net_arch": [64, 64],  # Schulman et al. 2017, section 6.1, as is the activation tanh
        "log_std_init": -1.0,  # as for trpo: docs/learners.md
    },
}
"""The hyperparameters. A rollout is one batch of the budget, and observations are standardized."""


def one_rollout_per_batch(num_envs: int, batch_steps: int) -> dict[str, Any]:
    """Steps per environment, rounded up, so that a stage has as many rollouts as its budget has batches."""
    return {"n_steps": math.ceil(batch_steps / num_envs)}


make = Sb3Factory(
    PPO,
    SETTINGS,
    Card(
        "ppo",
        "PPO",
        "Stable-Baselines3's PPO: 64-64 tanh, normalized observations, minibatches of 512.",
        hyperparameters={"rollout": "one batch of the budget"},
    ),
    normalize_observations=True,
    continue_counting=True,
    batch_settings=one_rollout_per_batch,
)

make_reset = with_addition(make, "reset")
make_snapshots = with_addition(make, "snapshots")
make_cloning = with_addition(make, "cloning")
make_online_ewc = with_addition(make, "online-ewc")
make_packnet = with_addition(make, "packnet")
