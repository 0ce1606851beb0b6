"""Every training seed, from the run's number and what the seed is for."""

from __future__ import annotations

import hashlib

import numpy as np


def training_seed(run: int, *purpose: str) -> int:
    """A seed in [0, 2³²) for one purpose of one run: ``SeedSequence([run, …])`` over the purpose's sha256."""
    digest = hashlib.sha256("/".join(purpose).encode()).digest()
    words = [int.from_bytes(digest[at : at + 4], "little") for at in range(0, 16, 4)]
    return int(np.random.SeedSequence([run, *words]).generate_state(1)[0])
