"""What a Stable-Baselines3 or SBX model has learned, as named values that a checkpoint can store."""

from __future__ import annotations

import sys
from operator import attrgetter
from typing import Any

import numpy as np
from stable_baselines3.common.base_class import BaseAlgorithm

from gym_extensions.baselines.agent import Array

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
