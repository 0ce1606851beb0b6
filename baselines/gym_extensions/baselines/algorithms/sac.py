"""SAC of SBX with small networks, and a replay buffer that is kept across tasks or emptied for each."""

import os
from dataclasses import replace

# One thread and the processor, as for every reference agent. JAX reads these variables when it is loaded.
os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1")
os.environ.setdefault("JAX_PLATFORMS", "cpu")

from sbx import SAC

from gym_extensions.baselines.adapters.sb3 import Sb3Factory
from gym_extensions.baselines.agent import Card
from gym_extensions.baselines.algorithms.sac64 import SETTINGS, TUNING, quarter_of_an_update_per_step

make = Sb3Factory(
    SAC,
    SETTINGS,
    Card(
        "sac",
        "SAC",
        "SBX's SAC: 64-64 ReLU, a quarter of an update per step, one replay buffer for all tasks.",
        hyperparameters={"updates_per_step": 0.25},
        **TUNING,
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
