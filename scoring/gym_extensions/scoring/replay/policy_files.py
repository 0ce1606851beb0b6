"""Which policies of a submission belong to a log."""

from __future__ import annotations

from gym_extensions.rollouts.folder import Folder
from gym_extensions.rollouts.layout import POLICIES, policy_name
from gym_extensions.rollouts.reading.evaluation_log import Log


def has_policies(log: Log, folder: Folder) -> bool:
    """Whether the submission has policies of a log. The rules say that it then has all of them."""
    prefix = f"{log.group.name}/{POLICIES}/{log.protocol}-"
    return any(path.startswith(prefix) for path in folder.files)


def policy_path(log: Log, run: int, stage: int, task_index: int) -> str:
    """The path in the submission of the policy that a cell was recorded with."""
    name = policy_name(log.protocol, run, stage, log.group.tasks[task_index].name)
    return f"{log.group.name}/{POLICIES}/{name}"
