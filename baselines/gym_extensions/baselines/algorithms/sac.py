"""SAC of SBX with small networks, and a replay buffer that is kept across tasks or emptied for each."""

import os
from dataclasses import replace
from typing import Any

# One thread and the processor, as for every reference agent. JAX reads these variables when it is loaded.
os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1")
os.environ.setdefault("JAX_PLATFORMS", "cpu")

from sbx import SAC

from gym_extensions.baselines.adapters.sb3 import Sb3Factory
from gym_extensions.baselines.agent import Card

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
        "sac",
        "SAC",
        "SBX's SAC: 64-64 ReLU, a quarter of an update per step, one replay buffer for all tasks.",
        hyperparameters={"updates_per_step": 0.25},
        tuning_steps=200_000,  # docs/learners.md
        tuning_tasks=("HalfCheetah",),
    ),
    continue_counting=True,
    batch_settings=quarter_of_an_update_per_step,
)

make_fresh_buffer = replace(
    make,
    continue_counting=False,
    fresh_buffer=True,
    card=replace(
        make.card,
        algorithm="sac-fresh-buffer",
        title="SAC (buffer emptied per task)",
        description="SBX's SAC as in the submission of sac, "
        "with a replay buffer that is emptied for each task.",
        parent="sac",
    ),
)
