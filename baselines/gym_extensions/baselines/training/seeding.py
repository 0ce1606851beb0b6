"""Training seeds, derived from the run's number and the purpose of the seed."""

from __future__ import annotations

import hashlib

import numpy as np


def training_seed(run: int, *purpose: str) -> int:
    """A seed in [0, 2³²) for one purpose in one run: ``SeedSequence([run, …])`` with the purpose's sha256."""
    digest = hashlib.sha256("/".join(purpose).encode()).digest()
    words = [int.from_bytes(digest[start : start + 4], "little") for start in range(0, 16, 4)]
    return int(np.random.SeedSequence([run, *words]).generate_state(1)[0])


def spawn_seeds(seed: int, num_envs: int) -> list[int]:
    """Spawns one seed per environment from one seed. Neighboring seeds share none of them."""
    return [int(child.generate_state(1)[0]) for child in np.random.SeedSequence(seed).spawn(num_envs)]
