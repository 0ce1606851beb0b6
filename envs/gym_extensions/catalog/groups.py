"""Every published group: an ordered, versioned list of tasks. The order is the training order."""

from __future__ import annotations

import functools
import re
from collections.abc import Mapping
from dataclasses import dataclass

from gym_extensions.catalog.mujoco_tasks import PLANAR_BODIES, RUNNING_BODIES
from gym_extensions.catalog.navigation_tasks import navigation_groups
from gym_extensions.catalog.registry import TASKS, task
from gym_extensions.catalog.task import Task
from gym_extensions.errors import BenchError, did_you_mean

NAME = re.compile(r"[a-z][a-z0-9-]{0,47}")
"""The name of a group."""

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
        name: the id without the version, for example ``hopper-gravity``: lower-case letters, digits, dashes.
        tasks: one or more different tasks, in training order.
        version: a whole number from 0; increases whenever the group changes.

    Raises:
        BenchError: an argument is invalid, or a task occurs twice.
    """

    name: str
    tasks: tuple[Task, ...]
    version: int = 0

    def __post_init__(self) -> None:
        tasks: object = self.tasks
        if not isinstance(self.name, str) or not NAME.fullmatch(self.name):
            hint = "Use up to 48 lower-case letters, digits and dashes, beginning with a letter."
            raise BenchError("bad-group", f"The group's name is {self.name!r}.", "name", hint)
        if type(self.version) is not int or self.version < 0:
            hint = "Give a whole number from 0."
            raise BenchError("bad-group", f"The group's version is {self.version!r}.", "version", hint)
        if not isinstance(tasks, tuple | list) or not all(isinstance(member, Task) for member in tasks):
            hint = "Give Task objects, as from gym_extensions.envs.customize."
            raise BenchError("bad-group", f"The tasks are {tasks!r}.", self.name, hint)
        object.__setattr__(self, "tasks", tuple(tasks))
        if not self.tasks:
            raise BenchError("bad-group", "The group has no task.", self.name, "Add at least one task.")
        for index, member in enumerate(self.tasks):
            if TASKS.get(member.id, member) != member:
                message = f"The task {member.id} has the id of a published task and another definition."
                hint = "Make the task with gym_extensions.envs.customize, which names it."
                raise BenchError("name-taken", message, self.name, hint)
            if member.id in [other.id for other in self.tasks[:index]]:
                hint = "List each task once."
                raise BenchError("duplicate-task", f"The task {member.id} occurs twice.", self.name, hint)

    @property
    def id(self) -> str:
        """The name with the version, for example ``hopper-gravity-v0``."""
        return f"{self.name}-v{self.version}"

    @functools.cached_property
    def task_ids(self) -> tuple[str, ...]:
        """The ids of the tasks, in training order."""
        return tuple(member.id for member in self.tasks)

    @property
    def published(self) -> bool:
        """Whether this is one of the published groups, and not a user's own."""
        return GROUPS.get(self.name) == self


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
