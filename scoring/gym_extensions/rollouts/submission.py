"""A submission that has been read."""

from __future__ import annotations

from dataclasses import dataclass

from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.rollouts.manifest import Manifest
from gym_extensions.rollouts.problem import Problem
from gym_extensions.rollouts.reading.evaluation_log import Log
from gym_extensions.rollouts.reading.interim_evaluations import Evaluations
from gym_extensions.rollouts.reading.training_curves import Curves


@dataclass(frozen=True)
class SubmittedGroup:
    """A group of a submission.

    ``logs`` are those without problems, by protocol; ``curves`` and ``evaluations`` are optional files.
    """

    group: TaskGroup
    logs: dict[str, Log]
    curves: Curves | None = None
    notes: tuple[str, ...] = ()
    evaluations: Evaluations | None = None


@dataclass(frozen=True)
class Submission:
    """A submission. With problems, it holds what could be read.

    ``readme`` is the text of README.md with ``\\n`` line ends; empty without one.
    """

    name: str
    manifest: Manifest | None
    groups: dict[str, SubmittedGroup]
    problems: tuple[Problem, ...] = ()
    readme: str = ""
