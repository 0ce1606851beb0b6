"""Makes vector environments, which step many copies of tasks together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import gymnasium as gym

from gym_extensions.catalog.registry import task as published_task
from gym_extensions.catalog.task import Task
from gym_extensions.envs.make import make
from gym_extensions.envs.protocols import Template
from gym_extensions.envs.seeding import WHERE
from gym_extensions.envs.vector.layout import is_vectorized
from gym_extensions.envs.vector.sync import SequentialVectorEnv
from gym_extensions.envs.vector.template import template
from gym_extensions.envs.vector.vector_env import MujocoVectorEnv
from gym_extensions.errors import BenchError


def make_vec(
    tasks: str | Task | Sequence[str | Task], num_envs: int, num_threads: int = 1
) -> gym.vector.VectorEnv[Any, Any, Any]:
    """Returns a vector environment whose numbers are bit for bit those of the single environments.

    Its autoreset mode is NEXT_STEP. MuJoCo environments that share a model layout and rules, as in a gravity
    or body group, run in one physics batch; others run in one batch each, one after the other. Tasks without
    rules on arrays are stepped one by one.

    Args:
        tasks: an id, a bare name or a Task, or a list of them; environment i has ``tasks[i % len(tasks)]``.
        num_envs: number of environments, at least 1.
        num_threads: threads that step physics. Results do not depend on it. The default is 1, because
            training processes usually run in parallel, one per core.

    Raises:
        BenchError: a task is unknown, there is no task, a count is below 1, or the tasks have different
            observation or action spaces.
    """
    requested = [tasks] if isinstance(tasks, str | Task) else list(tasks)
    _check_counts(len(requested), num_envs, num_threads)
    rows = [row if isinstance(row, Task) else published_task(row) for row in requested][:num_envs]
    copies = [rows[index % len(rows)] for index in range(num_envs)]
    if all(row.body.family == "navigation" for row in rows):
        from gym_extensions.envs.navigation.build import construct_vector

        return construct_vector(copies)
    if not all(map(is_vectorized, rows)):
        _check_spaces({row: make(row) for row in rows})
        return SequentialVectorEnv([partial(make, row) for row in copies])
    templates = {row: template(row) for row in rows}
    _check_spaces(templates)
    return MujocoVectorEnv([templates[row] for row in copies], num_threads)


def _check_counts(tasks: int, num_envs: int, num_threads: int) -> None:
    for name, count in (("tasks", tasks), ("num_envs", num_envs), ("num_threads", num_threads)):
        if count < 1:
            message = f"The number of tasks is {count}." if name == "tasks" else f"{name} is {count}."
            raise BenchError("bad-count", message, WHERE, "Give at least 1.")


def _check_spaces(environments: Mapping[Task, Template | gym.Env[Any, Any]]) -> None:
    (first, reference), *others = environments.items()
    for task, other in others:
        for name in ("observation_space", "action_space"):
            expected, space = getattr(reference, name), getattr(other, name)
            if expected != space:
                message = f"{first.id} has the {name} {expected}, {task.id} has {space}."
                raise BenchError("different-spaces", message, WHERE, "Give tasks with equal spaces.")
