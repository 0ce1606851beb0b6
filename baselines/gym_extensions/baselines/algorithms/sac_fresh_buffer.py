"""SAC whose replay buffer is emptied, and whose warm-up starts again, when the task changes."""

from __future__ import annotations

from dataclasses import replace

from gym_extensions.baselines.adapters.sb3 import Sb3Factory
from gym_extensions.baselines.algorithms.sac import OPTIONS

make = Sb3Factory(
    replace(
        OPTIONS,
        continue_counting=False,
        fresh_buffer=True,
        name="sac-fresh-buffer",
        title="SAC (buffer emptied per task)",
        description="SBX's SAC as in the entry of sac, with a replay buffer that is emptied for each task.",
    )
)
