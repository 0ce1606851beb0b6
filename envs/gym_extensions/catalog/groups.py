"""Groups of tasks that are trained in order and scored together, and suites of groups."""

import functools
import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gym_extensions.catalog import tasks as task_module
from gym_extensions.catalog.tasks import TASKS, Task, task
from gym_extensions.errors import BenchError, did_you_mean, whole_number

NAME = re.compile(r"[a-z][a-z0-9-]{0,47}")
"""The name of a group."""

GRAVITY_ORDER = ("GravityHalf", "GravityThreeQuarters", "", "GravityOneAndQuarter", "GravityOneAndHalf")
BODY_ORDER = tuple(f"{size}{part}" for size in task_module.SIZES for part in task_module.LIMBS)
HUMANOID_BODY_ORDER = BODY_ORDER + tuple(
    f"{size}{part}" for part in task_module.FURTHER_LIMBS["Humanoid"] for size in task_module.SIZES
)
"""What follows the body in the names of tasks, in training order."""
STANDING_UP = ("Humanoid", *task_module.STANDING_UP_BODIES)


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
        version = whole_number("version", self.version, "bad-group", "version", least=0)
        object.__setattr__(self, "version", version)
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


def _per_body(kind: str, bodies: tuple[str, ...], suffixes: tuple[str, ...]) -> dict[str, tuple[str, ...]]:
    return {f"{body.lower()}-{kind}": tuple(f"{body}{suffix}" for suffix in suffixes) for body in bodies}


def _groups(table: Mapping[str, tuple[str, ...]]) -> tuple[TaskGroup, ...]:
    return tuple(TaskGroup(name, tuple(map(task, names))) for name, names in table.items())


NAVIGATION = {
    f"nav-{family}": tuple(
        pattern.format(map=number, goal=goal) for number in task_module.MAPS for goal in task_module.GOALS
    )
    for family, pattern in task_module.FAMILIES.items()
}

PAPER_GROUPS = _groups(
    _per_body("gravity", task_module.RUNNING_BODIES, GRAVITY_ORDER)
    | _per_body("body", task_module.PLANAR_BODIES, BODY_ORDER)
    | _per_body("body", ("Humanoid",), HUMANOID_BODY_ORDER)
    | _per_body("wall", task_module.RUNNING_BODIES, ("WithSensor", "Wall"))
    | {
        "humanoid-standup-run": STANDING_UP,
        "humanoid-standup-run-wall": (
            *(f"{body}WithSensor" for body in STANDING_UP),
            "HumanoidStandupAndRunWall",
        ),
        "striker": ("Striker", "StrikerMovingStart"),
        "pusher": ("Pusher", "PusherMovingGoal"),
    }
    | NAVIGATION
)
"""The paper's groups."""

EXTRAS = _groups(
    _per_body("motor-noise", task_module.RUNNING_BODIES, ("", "MotorNoise"))
    | _per_body("noisy-wall", task_module.RUNNING_BODIES, ("WithSensor", "Wall", "NoisyWall"))
    | {
        "pusher-tracking": ("Pusher", "PusherTrackingGoal"),
        "striker-tracking": ("Striker", "StrikerTrackingGoal"),
    }
)
"""Groups that are not in the paper."""

GROUPS: dict[str, TaskGroup] = {each.name: each for each in (*PAPER_GROUPS, *EXTRAS)}
"""Every published group by its name without the version."""


def group(name: str) -> TaskGroup:
    """Returns the group of that name, with or without version (``hopper-gravity``, ``hopper-gravity-v0``).

    Raises:
        BenchError: no group has that name; the hint names the closest.
    """
    for each in GROUPS.values():
        if name in (each.name, each.id):
            return each
    hint = did_you_mean(name, GROUPS) or "gym-extensions envs list names them."
    raise BenchError("unknown-group", f"There is no group {name!r}.", hint=hint)


SUITE_BODIES = tuple(body.lower() for body in task_module.RUNNING_BODIES)
SUITES: dict[str, tuple[str, ...]] = {
    "gravity": tuple(f"{body}-gravity-v0" for body in SUITE_BODIES),
    "body": tuple(f"{body}-body-v0" for body in SUITE_BODIES),
    "wall": tuple(f"{body}-wall-v0" for body in SUITE_BODIES),
    "humanoid": ("humanoid-standup-run-v0", "humanoid-standup-run-wall-v0"),
    "arm": ("striker-v0", "pusher-v0"),
    "navigation": tuple(f"nav-{family}-v0" for family in task_module.FAMILIES),
}
"""The ids of the groups of every suite."""

CORE = "core-v1"
CORES: dict[str, tuple[str, ...]] = {
    CORE: (
        *(f"{body.lower()}-{kind}-v0" for kind in ("gravity", "wall") for body in task_module.PLANAR_BODIES),
        "hopper-body-v0",
    ),
}
"""The ids of the groups on which methods are compared as a whole, by version. The last one is in force.

A version never changes. It has seven groups of three bodies and three kinds of change, which cost 8.7 million
steps per run at 300,000 steps per task.
"""


def load_group(path: str | Path) -> TaskGroup:
    """Reads a custom group from a TOML file.

    The file holds ``name``, an optional ``version``, and a list of tasks in training order. Each task names a
    published task and may add variations and a time limit, or is the id of any Gymnasium environment::

        name = "hopper-light"

        [[tasks]]
        task = "Hopper"

        [[tasks]]
        task = "Hopper"
        variations = [{kind = "Gravity", factor = 0.3}]
        max_steps = 500

    Args:
        path: the TOML file.

    Returns:
        The group. Its tasks are published tasks wherever they equal one.

    Raises:
        BenchError: the file cannot be read or is not TOML; a key, task, kind of variation or parameter is
            unknown; a value is invalid; a task occurs twice; or the name belongs to a published group.
    """
    where = str(path)
    try:
        table = tomllib.loads(Path(path).read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise BenchError("unreadable-group", f"{error.strerror or error}.", where) from error
    except ValueError as error:
        raise BenchError("malformed-group", f"The file is not TOML: {error}.", where) from error
    task_module.check_keys(table, ("name", "version", "tasks"), ("name", "tasks"), where)
    tables = table["tasks"]
    if not isinstance(tables, list) or not all(isinstance(each, dict) for each in tables):
        hint = "Write [[tasks]] per task."
        raise BenchError("malformed-group", "tasks is not a list of tables.", where, hint)
    tasks = tuple(_task(each, f"{where}, task {number}") for number, each in enumerate(tables, 1))
    try:
        return resolve_group(TaskGroup(table["name"], tasks, table.get("version", 0)))
    except BenchError as error:
        raise BenchError(error.code, error.message, where, error.hint) from error


def resolve_group(named: str | Path | TaskGroup) -> TaskGroup:
    """The group that an argument or a command line names.

    Args:
        named: the name of a published group, a TaskGroup, or a path to a TOML file (it ends in ``.toml``).

    Raises:
        BenchError: there is no such group, the file is invalid, or a custom group has the name of a
            published one.
    """
    if isinstance(named, TaskGroup):
        if named.name in GROUPS and not named.published:
            message = f"{named.name!r} is the name of a published group with other tasks."
            raise BenchError("name-taken", message, "name", "Choose another name.")
        return named
    return load_group(named) if str(named).endswith(".toml") else group(str(named))


def groups_named(name: str | Path | TaskGroup) -> tuple[TaskGroup, ...]:
    """The groups that a word of a command line names: those of ``core`` (or ``core-v1``), or one group.

    Raises:
        BenchError: as :func:`resolve_group`.
    """
    version = CORE if name == "core" else str(name)
    if version in CORES:
        return tuple(map(group, CORES[version]))
    return (resolve_group(name),)


Groups = str | Path | TaskGroup | Iterable[str | Path | TaskGroup]
"""Groups by name, by TOML file or as TaskGroup objects, or one of these."""


def with_custom(groups: Groups) -> dict[str, TaskGroup]:
    """The published groups and these custom groups, or this one, by name.

    Raises ``BenchError`` if a group is invalid (see :func:`resolve_group`), or two have the same name.
    """
    known = dict(GROUPS)
    for each in map(resolve_group, [groups] if isinstance(groups, str | Path | TaskGroup) else groups):
        if known.setdefault(each.name, each) != each:
            message = f"Two groups have the name {each.name!r}."
            raise BenchError("name-taken", message, "--groups", "Rename one of them.")
    return known


def _task(table: Mapping[str, Any], where: str) -> Task:
    task_module.check_keys(table, ("task", "variations", "max_steps"), ("task",), where)
    variations = table.get("variations", [])
    if not isinstance(variations, list):
        hint = 'Write variations = [{kind = "Gravity", factor = 0.5}].'
        raise BenchError("malformed-group", "variations is not a list.", where, hint)
    try:
        made = [task_module.make_variation(each, where) for each in variations]
        return task_module.customize(str(table["task"]), made, max_steps=table.get("max_steps"))
    except BenchError as error:
        raise BenchError(error.code, error.message, error.where or where, error.hint) from error
