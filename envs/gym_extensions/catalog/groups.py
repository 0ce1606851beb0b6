"""Every published group: an ordered, versioned list of tasks. The order is the training order."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass

from gym_extensions.catalog.mujoco_tasks import PLANAR_BODIES, RUNNING_BODIES
from gym_extensions.catalog.navigation_tasks import navigation_groups
from gym_extensions.catalog.registry import task
from gym_extensions.catalog.task import Task
from gym_extensions.errors import BenchError, did_you_mean

GRAVITY_ORDER = (
    "{B}GravityHalf",
    "{B}GravityThreeQuarters",
    "{B}",
    "{B}GravityOneAndQuarter",
    "{B}GravityOneAndHalf",
)
BODY_ORDER = (
    "{B}SmallFoot",
    "{B}SmallLeg",
    "{B}SmallThigh",
    "{B}SmallTorso",
    "{B}BigFoot",
    "{B}BigLeg",
    "{B}BigThigh",
    "{B}BigTorso",
)
HUMANOID_BODY_ORDER = (
    *BODY_ORDER,
    "{B}SmallHead",
    "{B}BigHead",
    "{B}SmallArm",
    "{B}BigArm",
    "{B}SmallHand",
    "{B}BigHand",
)
SINGLE_GROUPS = {
    "humanoid-standup-run": ("Humanoid", "HumanoidStandup", "HumanoidStandupAndRun"),
    "humanoid-standup-run-wall": (
        "HumanoidWithSensor",
        "HumanoidStandupWithSensor",
        "HumanoidStandupAndRunWithSensor",
        "HumanoidStandupAndRunWall",
    ),
    "striker": ("Striker", "StrikerMovingStart"),
    "pusher": ("Pusher", "PusherMovingGoal"),
}
EXTRA_GROUPS = {
    "pusher-tracking": ("Pusher", "PusherTrackingGoal"),
    "striker-tracking": ("Striker", "StrikerTrackingGoal"),
}


@dataclass(frozen=True)
class TaskGroup:
    """Tasks that are trained in order and scored together.

    Args:
        name: the id without the version, for example ``hopper-gravity``.
        tasks: the tasks in training order.
        version: increases whenever the group changes.
    """

    name: str
    tasks: tuple[Task, ...]
    version: int = 0

    @property
    def id(self) -> str:
        """The published name, for example ``hopper-gravity-v0``."""
        return f"{self.name}-v{self.version}"

    @functools.cached_property
    def task_ids(self) -> tuple[str, ...]:
        """The ids of the tasks, in training order."""
        return tuple(member.id for member in self.tasks)


def _rows(kind: str, bodies: tuple[str, ...], names: tuple[str, ...]) -> list[TaskGroup]:
    return [
        TaskGroup(f"{body.lower()}-{kind}", tuple(task(name.format(B=body)) for name in names))
        for body in bodies
    ]


def _named(rows: Mapping[str, tuple[str, ...]]) -> list[TaskGroup]:
    return [TaskGroup(name, tuple(map(task, names))) for name, names in rows.items()]


PAPER_GROUPS: tuple[TaskGroup, ...] = (
    *_rows("gravity", RUNNING_BODIES, GRAVITY_ORDER),
    *_rows("body", PLANAR_BODIES, BODY_ORDER),
    *_rows("body", ("Humanoid",), HUMANOID_BODY_ORDER),
    *_rows("wall", RUNNING_BODIES, ("{B}WithSensor", "{B}Wall")),
    *_named(SINGLE_GROUPS),
    *_named(navigation_groups()),
)
"""The paper's groups."""

EXTRAS: tuple[TaskGroup, ...] = (
    *_rows("motor-noise", RUNNING_BODIES, ("{B}", "{B}MotorNoise")),
    *_rows("noisy-wall", RUNNING_BODIES, ("{B}WithSensor", "{B}Wall", "{B}NoisyWall")),
    *_named(EXTRA_GROUPS),
)
"""Groups that are not in the paper."""

GROUPS: dict[str, TaskGroup] = {row.name: row for row in (*PAPER_GROUPS, *EXTRAS)}
"""Every published group by its name without the version."""


def group(name: str) -> TaskGroup:
    """Returns the group of that name, with or without version (``hopper-gravity``, ``hopper-gravity-v0``).

    Raises:
        BenchError: no group has that name; the hint names the closest.
    """
    by_id = {row.id: row for row in GROUPS.values()}
    row = GROUPS.get(name) or by_id.get(name)
    if row is None:
        raise BenchError("unknown-group", f"There is no group {name!r}.", hint=did_you_mean(name, GROUPS))
    return row
