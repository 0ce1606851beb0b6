"""The state of a Stable-Baselines3 or SBX agent: generators, statistics and what the model has learned."""

from __future__ import annotations

import json
import random
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from operator import attrgetter
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.running_mean_std import RunningMeanStd
from stable_baselines3.common.vec_env import VecEnv, VecNormalize

from gym_extensions.baselines.agent import Array


def to_arrays(value: Any) -> dict[str, Array]:
    """A tree of dicts, lists, tuples, tensors, arrays and plain values as flat arrays without pickle.

    The array ``tree`` is the tree as JSON text, in which a number stands for each array.
    """
    arrays: list[Array] = []

    def encode(value: Any) -> Any:
        if isinstance(value, torch.Tensor):
            arrays.append(value.detach().numpy())
            return {"tensor": len(arrays) - 1}
        if isinstance(value, np.ndarray | np.generic):
            arrays.append(np.asarray(value))
            return {"array": len(arrays) - 1}
        if isinstance(value, dict):
            return {"dict": [[key, encode(item)] for key, item in value.items()]}
        if isinstance(value, list | tuple):
            return {type(value).__name__: [encode(item) for item in value]}
        return value

    tree = json.dumps(encode(value))
    return {"tree": np.array(tree), **{f"array{i}": array for i, array in enumerate(arrays)}}


def from_arrays(arrays: dict[str, Array]) -> Any:
    """The tree of :func:`to_arrays`."""
    decoders: dict[str, Callable[[Any], Any]] = {
        "tensor": lambda i: torch.from_numpy(arrays[f"array{i}"].copy()),
        "array": lambda i: arrays[f"array{i}"],
        "dict": lambda items: {key: decode(item) for key, item in items},
        "list": lambda items: [decode(item) for item in items],
        "tuple": lambda items: tuple(decode(item) for item in items),
    }

    def decode(value: Any) -> Any:
        if not isinstance(value, dict):
            return value
        ((kind, content),) = value.items()
        return decoders[kind](content)

    return decode(json.loads(str(arrays["tree"])))


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


STATISTICS = ("obs_rms", "ret_rms")
"""The statistics that a ``VecNormalize`` keeps: of observations, and of discounted returns."""


class Normalization:
    """Normalizes an agent's observations and rewards by running statistics, or neither.

    The statistics change in training only. Rewards are scaled for the model alone, not in the log.

    Args:
        observations: whether observations are standardized and clipped to ±10.
        rewards: whether rewards are divided by the standard deviation of the discounted return.
    """

    def __init__(self, observations: bool, rewards: bool) -> None:
        self._observations, self._rewards = observations, rewards
        self._wrapper: VecNormalize | None = None

    def wrap(self, env: VecEnv, discount: float) -> VecEnv:
        """The environment with normalized observations and rewards, which continues the statistics so far."""
        if not (self._observations or self._rewards):
            return env
        former = self._wrapper
        self._wrapper = VecNormalize(
            env, norm_obs=self._observations, norm_reward=self._rewards, gamma=discount
        )
        if former is not None:
            for name in self._names():
                setattr(self._wrapper, name, getattr(former, name))
        return self._wrapper

    def normalize(self, observations: Array) -> Array:
        """Observations (num_envs, …) as the model expects them. The statistics do not change."""
        return (
            observations if self._wrapper is None else np.asarray(self._wrapper.normalize_obs(observations))
        )

    def observation_statistics(self) -> tuple[Array, Array, float] | None:
        """Mean, standard deviation and limit of standardized observations; None if they are not changed."""
        if self._wrapper is None or not self._observations:
            return None
        statistics: Any = self._wrapper.obs_rms
        deviation = np.sqrt(statistics.var + self._wrapper.epsilon)
        return statistics.mean, deviation, float(self._wrapper.clip_obs)

    def state(self) -> dict[str, Any]:
        """Mean, variance and count of every statistic, by name."""
        return {name: dict(vars(getattr(self._wrapper, name))) for name in self._names()}

    def restore(self, state: dict[str, Any]) -> None:
        """Sets the statistics to a state of :meth:`state`."""
        for name, values in state.items():
            statistics = RunningMeanStd()
            vars(statistics).update(values)
            setattr(self._wrapper, name, statistics)

    def _names(self) -> list[str]:
        return [name for name in STATISTICS if hasattr(self._wrapper, name)]


CLOCK = ("start_time",)
"""Numbers of a model that depend on the clock. They are not stored, so that equal runs have equal bytes."""


def model_state(model: BaseAlgorithm) -> dict[str, Any]:
    """Networks, optimizers, JAX arrays, counters and the replay buffer of a model, by kind."""
    modules, variables = model._get_torch_save_params()
    return {
        "modules": {name: attrgetter(name)(model).state_dict() for name in modules},
        "variables": {name: attrgetter(name)(model) for name in variables},
        "jax": _jax_leaves(model),
        "counters": {
            name: value
            for name, value in sorted(vars(model).items())
            if isinstance(value, bool | int | float) and name not in CLOCK
        },
        "replay_buffer": _buffer_state(getattr(model, "replay_buffer", None)),
    }


def restore_model(model: BaseAlgorithm, state: dict[str, Any]) -> None:
    """Sets a model with the same settings and number of environments to a state of :func:`model_state`."""
    for name, values in state["modules"].items():
        attrgetter(name)(model).load_state_dict(values)
    for name, values in state["variables"].items():
        attrgetter(name)(model).data = values
    _restore_jax(model, state["jax"])
    vars(model).update(state["counters"])
    if state["replay_buffer"] is not None:
        _restore_buffer(getattr(model, "replay_buffer", None), state["replay_buffer"])


def num_parameters(model: BaseAlgorithm) -> int:
    """The number of a model's network parameters, target networks included."""
    from_torch = sum(values.numel() for values in model.policy.parameters())
    states = [value for _, _, value in _jax_holders(model) if hasattr(value, "params")]
    if not states:
        return from_torch
    from jax.tree_util import tree_leaves

    trees = [tree_leaves((state.params, getattr(state, "target_params", ()))) for state in states]
    return int(from_torch + sum(leaf.size for leaves in trees for leaf in leaves))


def stored_steps(model: BaseAlgorithm) -> int:
    """The transitions in a model's replay buffer, or in its rollouts if it has none."""
    buffer = getattr(model, "replay_buffer", None)
    steps = getattr(model, "n_steps", 0) if buffer is None else buffer.size()
    return int(steps) * model.n_envs


def _jax_holders(model: BaseAlgorithm) -> list[tuple[Any, str, Any]]:
    """The attributes of a model and its policy that hold JAX arrays: object, attribute and value."""
    if "jax" not in sys.modules:
        return []
    import jax
    from flax.training.train_state import TrainState

    return [
        (owner, name, value)
        for owner in (model, model.policy)
        for name, value in sorted(vars(owner).items())
        if isinstance(value, jax.Array | TrainState)
    ]


def _jax_leaves(model: BaseAlgorithm) -> dict[str, list[Array]]:
    """The arrays of each attribute. Python's numbers among them have JAX's types, as after a restoration."""
    holders = _jax_holders(model)
    if not holders:
        return {}
    from jax.numpy import asarray
    from jax.tree_util import tree_leaves

    return {
        f"{type(owner).__name__}.{name}": [np.asarray(asarray(leaf)) for leaf in tree_leaves(value)]
        for owner, name, value in holders
    }


def _restore_jax(model: BaseAlgorithm, leaves: dict[str, list[Array]]) -> None:
    holders = _jax_holders(model)
    if not holders:
        return
    import jax.numpy as jnp
    from jax.tree_util import tree_structure, tree_unflatten

    for owner, name, value in holders:
        arrays = [jnp.asarray(leaf) for leaf in leaves[f"{type(owner).__name__}.{name}"]]
        setattr(owner, name, tree_unflatten(tree_structure(value), arrays))


def _buffer_state(buffer: Any) -> dict[str, Any] | None:
    """The filled rows of a replay buffer's arrays, and its position."""
    if buffer is None:
        return None
    rows = buffer.buffer_size if buffer.full else buffer.pos
    arrays = {name: values[:rows] for name, values in _buffer_arrays(buffer).items()}
    return {"arrays": arrays, "pos": buffer.pos, "full": buffer.full}


def _restore_buffer(buffer: Any, state: dict[str, Any]) -> None:
    for name, values in _buffer_arrays(buffer).items():
        values[: len(state["arrays"][name])] = state["arrays"][name]
    buffer.pos, buffer.full = state["pos"], state["full"]


def _buffer_arrays(buffer: Any) -> dict[str, Array]:
    return {
        name: values
        for name, values in sorted(vars(buffer).items())
        if isinstance(values, np.ndarray) and values.shape[:1] == (buffer.buffer_size,)
    }
