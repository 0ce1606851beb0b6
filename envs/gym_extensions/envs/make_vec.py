"""Makes vector environments, which step many copies of tasks together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import gymnasium as gym
from gymnasium.vector import SyncVectorEnv

from gym_extensions.catalog.task import Task
from gym_extensions.envs.batch.seeding import WHERE, check_count
from gym_extensions.envs.gym_request import Request, check_keywords, request, resolve
from gym_extensions.envs.make import make
from gym_extensions.envs.protocols import Template
from gym_extensions.envs.vector.layout import is_vectorized
from gym_extensions.envs.vector.template import template
from gym_extensions.envs.vector.vector_env import MujocoVectorEnv
from gym_extensions.errors import BenchError

MAX_NUM_ENVS, MAX_NUM_THREADS = 100_000, 1024
"""Larger counts are mistakes: no machine has the memory or the processors."""


def make_vec(
    tasks: str | Task | Sequence[str | Task], num_envs: int, num_threads: int = 1
) -> gym.vector.VectorEnv[Any, Any, Any]:
    """Returns a vector environment whose numbers are bit for bit those of the single environments.

    Its autoreset mode is NEXT_STEP. MuJoCo environments that share a model layout and rules, as in a gravity
    or body group, run in one physics batch; others run in one batch each, one after the other. Tasks without
    rules on arrays are stepped one by one. ``gymnasium.make_vec`` of a published id returns the same.

    An int seed of ``reset`` gives environment i the seed ``seed + i``, and infos are those of the single
    environments, as in Gymnasium's vector environments.

    Args:
        tasks: an id, a bare name or a Task, or a list of them; environment i has ``tasks[i % len(tasks)]``.
        num_envs: number of environments, 1 to 100,000.
        num_threads: threads that step physics. Results do not depend on it. The default is 1, because
            training processes usually run in parallel, one per core.

    Raises:
        BenchError: a task is unknown, there is no task, a count is out of range, or the tasks have different
            observation or action spaces.
    """
    requested = [tasks] if isinstance(tasks, str | Task) else list(tasks)
    if not requested:
        raise BenchError("no-tasks", "There is no task.", WHERE, "Give at least 1.")
    count = check_count("num_envs", num_envs, MAX_NUM_ENVS)
    threads = check_count("num_threads", num_threads, MAX_NUM_THREADS)
    rows = [resolve(row) for row in requested][:count]
    copies = [rows[index % len(rows)] for index in range(count)]
    if all(row.body.family == "navigation" for row in rows):
        from gym_extensions.envs.navigation.build import construct_vector

        return construct_vector(copies)
    if not all(map(is_vectorized, rows)):
        _check_spaces({row: make(row) for row in rows})
        return SyncVectorEnv([partial(make, row) for row in copies])
    templates = {row: template(row) for row in rows}
    _check_spaces(templates)
    return MujocoVectorEnv([templates[row] for row in copies], threads)


def construct(
    num_envs: int,
    task: str | Task | Mapping[str, Any],
    max_episode_steps: int | None = None,
    num_threads: int = 1,
    **others: Any,
) -> gym.vector.VectorEnv[Any, Any, Any]:
    """Returns ``make_vec`` of one task, as ``gymnasium.make_vec`` calls it.

    Raises:
        BenchError: as in ``make_vec``; or a keyword or time limit would change the task, or asks for
            rendering.
    """
    asked = request()
    limit = None if asked is None else Request(asked.id, max_episode_steps)
    row = resolve(task, limit)
    check_keywords(row, others)
    if any(value is not None for value in others.values()):
        hint = 'Use vectorization_mode="sync", or make(task, render_mode=...).'
        raise BenchError(
            "no-rendering", "Environments that are stepped together do not render.", row.id, hint
        )
    return make_vec(row, num_envs, num_threads)


def _check_spaces(environments: Mapping[Task, Template | gym.Env[Any, Any]]) -> None:
    (first, reference), *others = environments.items()
    for task, other in others:
        for name in ("observation_space", "action_space"):
            expected, space = getattr(reference, name), getattr(other, name)
            if expected != space:
                message = f"{first.id} has the {name} {expected}, {task.id} has {space}."
                raise BenchError("different-spaces", message, WHERE, "Give tasks with equal spaces.")
