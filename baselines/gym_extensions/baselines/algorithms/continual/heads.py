"""What a policy with one output layer per task stores for each task."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gym_extensions.baselines.agent import Array, VectorEnv
from gym_extensions.baselines.trpo.mlp import Sizes, parameter_count
from gym_extensions.baselines.trpo.normalization import Moments
from gym_extensions.errors import BenchError


@dataclass(frozen=True)
class Head:
    """A task's own part of the policy.

    Args:
        parameters: of the output layer, then log σ (k,).
        moments: of the observations, at the end of the task.
        number: 1 for the task that was learned first, 2 for the second, and so on.
    """

    parameters: Array
    moments: Moments
    number: int


Heads = dict[int, Head]
"""Heads by the index of their task in the group."""


def hidden_count(sizes: Sizes) -> int:
    """Number of parameters of the hidden layers, which come first in the flat vector."""
    return parameter_count(sizes[:-1])


def trained_task(env: VectorEnv, name: str) -> int:
    """The index of the task that all environments run.

    Raises:
        BenchError: they run several tasks, as in the protocol ``joint``.
    """
    tasks = np.unique(env.env_tasks)  # type: ignore[attr-defined]  # of the training environments
    if len(tasks) > 1:
        hint = "Use the protocol sequential or single, or an agent without heads, such as trpo."
        message = f"The agent learns a single task at a time, but the environments run {len(tasks)} tasks."
        raise BenchError("single-task-agent", message, name, hint)
    return int(tasks[0])


def to_arrays(heads: Heads) -> dict[str, Array]:
    """The heads as named arrays."""
    arrays: dict[str, Array] = {"head_tasks": np.array(list(heads), np.int64)}
    for task, head in heads.items():
        moments = head.moments
        arrays |= {
            f"head{task}_parameters": head.parameters,
            f"head{task}_count": np.array(moments.count),
            f"head{task}_mean": moments.mean,
            f"head{task}_squares": moments.squares,
            f"head{task}_number": np.array(head.number),
        }
    return arrays


def from_arrays(arrays: Mapping[str, Array]) -> Heads:
    """The heads that :func:`to_arrays` saved."""
    heads = {}
    for task in arrays["head_tasks"].tolist():
        part = {name: arrays[f"head{task}_{name}"] for name in ("mean", "squares", "parameters")}
        moments = Moments(float(arrays[f"head{task}_count"]), part["mean"], part["squares"])
        heads[task] = Head(part["parameters"], moments, int(arrays[f"head{task}_number"]))
    return heads
