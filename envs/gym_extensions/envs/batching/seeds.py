"""One seed a lane from one seed."""

from __future__ import annotations

import numpy as np


def lane_seeds(seed: int, num_envs: int) -> list[int]:
    """One seed a lane, spawned from one seed, so that neighbouring seeds share no lane."""
    return [int(child.generate_state(1)[0]) for child in np.random.SeedSequence(seed).spawn(num_envs)]
