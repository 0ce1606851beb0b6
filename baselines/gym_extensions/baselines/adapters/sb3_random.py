"""The random generators of Stable-Baselines3, which are global, as a state per purpose."""

from __future__ import annotations

import random
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import torch

State = tuple[Any, Any, Any]
"""The states of the generators of torch, numpy and Python."""


class Generators:
    """The states of the global generators of torch, numpy and Python for one purpose, such as acting.

    Args:
        seed: of all three.
    """

    def __init__(self, seed: int) -> None:
        self.state: State = (
            torch.Generator().manual_seed(seed).get_state(),
            np.random.RandomState(seed).get_state(),
            random.Random(seed).getstate(),
        )

    @contextmanager
    def active(self) -> Iterator[None]:
        """The global generators continue from this state inside the context and are restored after it."""
        outside = _global_state()
        _set_global_state(self.state)
        try:
            yield
        finally:
            self.state = _global_state()
            _set_global_state(outside)


def _global_state() -> State:
    # SB3 draws from numpy's legacy generator.
    return torch.get_rng_state(), np.random.get_state(), random.getstate()  # noqa: NPY002


def _set_global_state(state: State) -> None:
    torch.set_rng_state(state[0])
    np.random.set_state(state[1])  # noqa: NPY002
    random.setstate(state[2])


class PolicyKeys:
    """JAX keys with which an SBX policy samples while it acts, separate from those of its training.

    SBX keeps the keys in the policy's attributes ``key`` and ``noise_key``. Policies of SB3 have none.
    """

    NAMES = ("key", "noise_key")

    def __init__(self, policy: Any, seed: int) -> None:
        self.keys: dict[str, Any] = {}
        if all(hasattr(policy, name) for name in self.NAMES):
            from jax.random import PRNGKey

            self.keys = {name: PRNGKey(seed) for name in self.NAMES}

    @contextmanager
    def active(self, policy: Any) -> Iterator[None]:
        """The policy samples with these keys inside the context and has its former keys after it."""
        outside = {name: getattr(policy, name) for name in self.keys}
        vars(policy).update(self.keys)
        try:
            yield
        finally:
            self.keys = {name: getattr(policy, name) for name in self.keys}
            vars(policy).update(outside)

    def state(self) -> dict[str, Any]:
        """The keys as arrays, by name."""
        return {name: np.asarray(key) for name, key in self.keys.items()}

    def restore(self, state: dict[str, Any]) -> None:
        """Sets the keys to a state of :meth:`state`."""
        if state:
            from jax.numpy import asarray

            self.keys = {name: asarray(key) for name, key in state.items()}
