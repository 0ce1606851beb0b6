"""What ``gymnasium.make`` or ``gymnasium.make_vec`` was called with, as seen from an entry point.

Gymnasium passes neither the id nor ``max_episode_steps`` to an entry point, so a changed time limit or task
could not be refused without a look at its call.
"""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gymnasium.envs import registration

from gym_extensions.catalog.definitions import from_definition
from gym_extensions.catalog.registry import TASKS
from gym_extensions.catalog.registry import task as published_task
from gym_extensions.catalog.task import Task
from gym_extensions.errors import BenchError

CALLS = {registration.make.__code__: "gymnasium.make", registration.make_vec.__code__: "gymnasium.make_vec"}
CAMERA = (
    *("width", "height", "camera_id", "camera_name"),
    *("default_camera_config", "max_geom", "visual_options"),
)
HINT = "A task's reward, body and time limit are fixed. For another task use gym_extensions.envs.customize."
"""What to do instead of changing a task."""


@dataclass(frozen=True)
class Request:
    """The id and the time limit that Gymnasium applies; None for no limit of its own."""

    id: str
    max_steps: int | None


def request() -> Request | None:
    """Returns the request of the Gymnasium call two frames above, or None if there is none."""
    frame = inspect.currentframe()
    for _ in range(2):
        frame = None if frame is None else frame.f_back
    if frame is None or frame.f_code not in CALLS:
        return None
    spec = frame.f_locals["env_spec"]
    limit = frame.f_locals.get("max_episode_steps")
    return Request(spec.id, spec.max_episode_steps if limit is None else limit)


def resolve(task: str | Task | Mapping[str, Any], asked: Request | None = None) -> Task:
    """Returns the task of an id, a bare name, a Task or a definition.

    Raises:
        BenchError: the task is unknown, it has a published id and other content, or Gymnasium was asked for
            another id or time limit.
    """
    if isinstance(task, str):
        row = published_task(task)
    else:
        row = task if isinstance(task, Task) else from_definition(task)
    if TASKS.get(row.id, row) != row:
        message = "The task has the id of a published task and other content."
        raise BenchError("changed-task", message, row.id, "Give it another name.")
    if asked is not None:
        if asked.id in TASKS and asked.id != row.id:
            raise BenchError("changed-task", f"The keyword task is {row.id}.", asked.id, HINT)
        if asked.max_steps not in (None, row.max_steps):
            message = f"max_episode_steps is {asked.max_steps}; the task has {row.max_steps}."
            raise BenchError("changed-task", message, row.id, HINT)
    return row


def check_keywords(row: Task, keywords: Mapping[str, Any]) -> None:
    """Raises ``BenchError`` for keywords of an environment that are not about rendering."""
    accepted = ("render_mode",) if row.body.family == "navigation" else ("render_mode", *CAMERA)
    for name in keywords:
        if name not in accepted:
            hint = f"It accepts {', '.join(accepted)}. {HINT}"
            raise BenchError("changed-task", f"The task does not accept {name}.", row.id, hint)
