"""SAC of Stable-Baselines3 with small networks, and additions to its actor.

The settings are those of ``sac``, which is the SAC of SBX. The replay buffer is emptied for each task, as in
``sac-fresh-buffer``: with the steps of earlier tasks in it, every addition would be combined with replay,
and the head of a task would be trained on other tasks.
"""

from typing import Any

from stable_baselines3 import SAC

from gym_extensions.baselines.adapters.sb3 import Sb3Factory
from gym_extensions.baselines.agent import Card
from gym_extensions.baselines.algorithms.additions import with_addition

SETTINGS: dict[str, Any] = {
    "learning_rate": 1e-3,  # docs/learners.md; Haarnoja et al. 2018 use 3e-4, with four times as many updates
    "buffer_size": 1_000_000,  # Haarnoja et al. 2018, table 1
    "learning_starts": 1_000,  # this project: one episode of the planar bodies
    "batch_size": 128,  # this project, for speed; Haarnoja et al. use 256
    "tau": 0.005,  # Haarnoja et al. 2018, table 1
    "gamma": 0.99,  # the same
    "train_freq": 4,  # with gradient_steps below: a quarter of an update per step, for speed
    "policy_kwargs": {"net_arch": [64, 64]},  # this project, for speed; Haarnoja et al. use 256-256
}
"""The hyperparameters."""


def quarter_of_an_update_per_step(num_envs: int, batch_steps: int) -> dict[str, Any]:
    """As many updates as environments, after ``train_freq`` = 4 steps of each."""
    return {"gradient_steps": num_envs}


make = Sb3Factory(
    SAC,
    SETTINGS,
    Card(
        "sac64",
        "SAC 64-64",
        "Stable-Baselines3's SAC: 64-64 ReLU, a quarter of an update per step, "
        "with a replay buffer that is emptied for each task.",
        hyperparameters={"updates_per_step": 0.25},
        tuning_steps=200_000,  # of sac: docs/learners.md
        tuning_tasks=("HalfCheetah",),
    ),
    fresh_buffer=True,
    batch_settings=quarter_of_an_update_per_step,
)

make_reset = with_addition(make, "reset")
make_snapshots = with_addition(make, "snapshots")
make_packnet = with_addition(make, "packnet")
# Not tuned; larger than those of ppo, because the actor's loss has the scale of returns.
make_cloning = with_addition(make, "cloning", coefficient=10.0)
make_online_ewc = with_addition(make, "online-ewc", coefficient=10.0)
