"""Many copies of tasks stepped at once, as a Gymnasium vector environment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import gymnasium as gym

from gym_extensions.catalog.registry import task as published
from gym_extensions.catalog.task import Task
from gym_extensions.envs.make import make
from gym_extensions.envs.seeding import WHERE, lane_seeds
from gym_extensions.envs.vector.registry import stepped_at_once
from gym_extensions.envs.vector.sync import OneByOne
from gym_extensions.envs.vector.template import Prototype, prototype
from gym_extensions.envs.vector.vector_env import BatchVectorEnv
from gym_extensions.errors import BenchError

__all__ = ["lane_seeds", "make_batch"]


def make_batch(
    tasks: str | Task | Sequence[str | Task], num_envs: int, num_threads: int = 1
) -> gym.vector.VectorEnv[Any, Any, Any]:
    """``num_envs`` lanes stepped at once, bit for bit the single environments, in autoreset mode NEXT_STEP.

    Lanes that share a model layout and rules, as those of a gravity or body group do, run in one physics
    batch. Others run in a batch each, one after the other, behind the same vector environment. Tasks without
    whole-array rules are stepped one by one, through their single environments.

    Args:
        tasks: an id, a bare name or a Task, or a list of them; lane i holds ``tasks[i mod len(tasks)]``.
        num_envs: lanes, at least 1.
        num_threads: threads that step physics; results do not depend on it. One by default, since training
            processes usually run side by side, one a core.

    Raises:
        BenchError: an unknown task, no task, fewer than one lane or thread, or tasks whose observations or
            actions differ in shape.
    """
    given = [tasks] if isinstance(tasks, str | Task) else list(tasks)
    _check_counts(len(given), num_envs, num_threads)
    rows = [row if isinstance(row, Task) else published(row) for row in given][:num_envs]
    if all(row.base == "Navigation" for row in rows):
        from gym_extensions.envs.navigation.build import construct_batch

        return construct_batch([rows[lane % len(rows)] for lane in range(num_envs)])
    if not all(map(stepped_at_once, rows)):
        _check_spaces({row: make(row) for row in rows})
        return OneByOne([partial(make, rows[lane % len(rows)]) for lane in range(num_envs)])
    models = {row: prototype(row) for row in rows}
    _check_spaces(models)
    return BatchVectorEnv([models[rows[lane % len(rows)]] for lane in range(num_envs)], num_threads)


def _check_counts(tasks: int, num_envs: int, num_threads: int) -> None:
    for what, count in (("tasks", tasks), ("num_envs", num_envs), ("num_threads", num_threads)):
        if count < 1:
            raise BenchError("bad-count", f"{what} is {count}.", WHERE, "Give at least 1.")


def _check_spaces(lanes: Mapping[Task, Prototype | gym.Env[Any, Any]]) -> None:
    (first, one), *others = lanes.items()
    for task, other in others:
        for what in ("observation_space", "action_space"):
            mine, theirs = getattr(one, what), getattr(other, what)
            if mine != theirs:
                message = f"{first.id} has the {what} {mine}, {task.id} has {theirs}."
                raise BenchError("different-spaces", message, WHERE, "Give tasks that share their spaces.")
