"""A submission that has been read."""

from __future__ import annotations

from dataclasses import dataclass, field

from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.rollouts.manifest import Manifest
from gym_extensions.rollouts.problem import Problem
from gym_extensions.rollouts.reading.evaluation_log import Log
from gym_extensions.rollouts.reading.interim_evaluations import Evaluations
from gym_extensions.rollouts.reading.training_curves import Curves


@dataclass(frozen=True)
class Evidence:
    """The audit sample of a log: the number of its traces, how many of them are missing, and its salt.

    ``sample`` is 0 if the log commits to no traces; ``salt`` is empty if none drew the sample.
    """

    sample: int = 0
    missing: int = 0
    salt: str = ""


@dataclass(frozen=True)
class SubmittedGroup:
    """A group of a submission.

    ``logs`` are those without problems, by protocol; ``curves`` and ``evaluations`` are optional files.
    ``evidence`` says what the traces of each of these logs cover.
    """

    group: TaskGroup
    logs: dict[str, Log]
    curves: Curves | None = None
    notes: tuple[str, ...] = ()
    evaluations: Evaluations | None = None
    evidence: dict[str, Evidence] = field(default_factory=dict)


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
