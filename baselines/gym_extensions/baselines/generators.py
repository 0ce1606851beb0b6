"""Random generators: those of an agent, and the global ones of Python, numpy and torch."""

from __future__ import annotations

import json
import random
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np


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


@contextmanager
def preserved_global_generators() -> Iterator[None]:
    """Restores the global random generators."""
    state = global_generators()
    try:
        yield
    finally:
        set_global_generators(state)


@contextmanager
def seeded_global_generators(seed: int) -> Iterator[None]:
    """Seeds the global random generators, for agents that draw from them, and restores them."""
    with preserved_global_generators():
        random.seed(seed)
        np.random.seed(seed % 2**32)  # noqa: NPY002
        if torch := sys.modules.get("torch"):
            torch.manual_seed(seed)
        yield
