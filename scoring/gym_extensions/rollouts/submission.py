"""What a submission is once it has been read."""

from __future__ import annotations

from dataclasses import dataclass

from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.rollouts.manifest import Manifest
from gym_extensions.rollouts.problem import Problem
from gym_extensions.rollouts.reading.evaluation_log import Log
from gym_extensions.rollouts.reading.training_curves import Curves


@dataclass(frozen=True)
class GroupEntry:
    """What a submission holds of one group: the checked logs by protocol, the training curves, notes."""

    group: TaskGroup
    logs: dict[str, Log]
    curves: Curves | None = None
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Submission:
    """A submission in which no rule found a problem, or what could be read of it."""

    name: str
    manifest: Manifest | None
    groups: dict[str, GroupEntry]
    problems: tuple[Problem, ...] = ()
