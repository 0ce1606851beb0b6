"""Random numbers: the seeds of a run, the generators of an agent, and the global ones."""

import copy
import hashlib
import itertools
import json
import random
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import gymnasium as gym
import numpy as np


def training_seed(run: int, *purpose: str) -> int:
    """A seed in [0, 2³²) for one purpose in one run: ``SeedSequence([run, …])`` with the purpose's sha256."""
    digest = hashlib.sha256("/".join(purpose).encode()).digest()
    words = [int.from_bytes(digest[start : start + 4], "little") for start in range(0, 16, 4)]
    return int(np.random.SeedSequence([run, *words]).generate_state(1)[0])


def spawn_seeds(seed: int, num_envs: int) -> list[int]:
    """Spawns one seed per environment from one seed. Neighboring seeds share none of them."""
    return [int(child.generate_state(1)[0]) for child in np.random.SeedSequence(seed).spawn(num_envs)]


def seeded_copy(space: gym.Space[Any], seed: int) -> gym.Space[Any]:
    """A copy of a space that samples from a seed of its own."""
    own = copy.deepcopy(space)
    own.seed(seed % 2**31)
    return own


def acting_and_learning(seed: int) -> tuple[np.random.Generator, np.random.Generator]:
    """Two independent generators from one seed, so that evaluation leaves training untouched."""
    acting, learning = np.random.SeedSequence(seed).spawn(2)
    return np.random.default_rng(acting), np.random.default_rng(learning)


def saved_generator(generator: np.random.Generator) -> str:
    """The state of a random generator as text."""
    return json.dumps(generator.bit_generator.state, sort_keys=True)


def restore_generator(generator: np.random.Generator, saved: str) -> None:
    """Sets a random generator to a state from :func:`saved_generator`."""
    generator.bit_generator.state = json.loads(saved)


def global_generators() -> tuple[Any, Any, Any]:
    """The states of the global random generators of Python, numpy and (if it is loaded) torch."""
    torch = sys.modules.get("torch")
    return random.getstate(), np.random.get_state(), torch and torch.get_rng_state()  # noqa: NPY002


def set_global_generators(state: tuple[Any, Any, Any]) -> None:
    """Sets the global random generators to a state of :func:`global_generators`."""
    random.setstate(state[0])
    np.random.set_state(state[1])  # noqa: NPY002
    if state[2] is not None:
        sys.modules["torch"].set_rng_state(state[2])


SCOPES: list[tuple[int, int | None]] = []
"""The open blocks of ``preserved_global_generators``, outermost first: a number of its own, and its seed.

An agent in another process has generators of its own, which are seeded and restored at the same places.
"""
NUMBERS = itertools.count()


def seed_global_generators() -> None:
    """Seeds them with the seed of the innermost open block; again after an import that may load torch."""
    if SCOPES and (seed := SCOPES[-1][1]) is not None:
        random.seed(seed)
        np.random.seed(seed % 2**32)  # noqa: NPY002
        if torch := sys.modules.get("torch"):
            torch.manual_seed(seed)


@contextmanager
def preserved_global_generators(seed: int | None = None) -> Iterator[None]:
    """Restores the global random generators, which start from the seed if there is one.

    Agents may draw from them.
    """
    state = global_generators()
    SCOPES.append((next(NUMBERS), seed))
    try:
        seed_global_generators()
        yield
    finally:
        SCOPES.pop()
        set_global_generators(state)
