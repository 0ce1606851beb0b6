"""SAC of SBX with small networks, and a replay buffer that is kept across tasks or emptied for each."""

import os
from dataclasses import replace

# One thread and the processor, as for every reference agent. JAX reads these variables when it is loaded.
os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1")
os.environ.setdefault("JAX_PLATFORMS", "cpu")

from sbx import SAC

from gym_extensions.baselines.algorithms import sac64

make = replace(
    sac64.make,
    algorithm=SAC,
    continue_counting=True,
    fresh_buffer=False,
    card=replace(
        sac64.make.card,
        algorithm="sac",
        title="SAC",
        description="SBX's SAC: 64-64 ReLU, a quarter of an update per step, "
        "one replay buffer for all tasks.",
    ),
)

make_fresh_buffer = replace(
    sac64.make,
    algorithm=SAC,
    card=replace(
        sac64.make.card,
        algorithm="sac-fresh-buffer",
        title="SAC (buffer emptied per task)",
        description="SBX's SAC as in the submission of sac, "
        "with a replay buffer that is emptied for each task.",
        parent="sac",
    ),
)
