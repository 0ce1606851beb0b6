"""Tasks: one environment each, as data. Published ones are tables; customize makes others."""

import importlib
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import MISSING, asdict, astuple, dataclass, fields, replace
from typing import Any

from gym_extensions.catalog import variations
from gym_extensions.catalog.bodies import BODIES, DEFAULT_MAX_STEPS, UNBOUNDED, Body
from gym_extensions.catalog.variations import KINDS, Variation
from gym_extensions.errors import BenchError, did_you_mean, require_known, whole_number

NAMESPACE = "gym_extensions"
GYMNASIUM_ID = re.compile(r"(?:[\w.]+:)?[\w./-]+-v\d+", re.ASCII)
"""The id of another package's environment in Gymnasium's registry, perhaps after a module to import."""


@dataclass(frozen=True)
class Task:
    """One environment as data.

    Args:
        name: the id without namespace and version, for example ``HopperGravityHalf``; the id itself where
            the base is one of Gymnasium's registry.
        base: the name of the base body, or an id of Gymnasium's registry (``Pendulum-v1``).
        variations: what differs from the base body.
        version: increases whenever the task changes.
        max_steps: the time limit in environment steps.
    """

    name: str
    base: str
    variations: tuple[Variation, ...] = ()
    version: int = 0
    max_steps: int = DEFAULT_MAX_STEPS

    @property
    def id(self) -> str:
        """The Gymnasium id, for example ``gym_extensions/HopperGravityHalf-v0``."""
        return self.name if self.is_foreign else f"{NAMESPACE}/{self.name}-v{self.version}"

    @property
    def bare_name(self) -> str:
        """What commands and files call a published task: its name, from version 1 on with the version."""
        return f"{self.name}-v{self.version}" if self.version else self.name

    @property
    def is_foreign(self) -> bool:
        """Whether the base is an environment of another package, by its id in Gymnasium's registry."""
        return GYMNASIUM_ID.fullmatch(self.base) is not None

    @property
    def body(self) -> Body:
        """The base body. Raises ``BenchError`` if no body has that name; the hint names the closest."""
        if self.is_foreign:
            return Body(self.base, "gymnasium", "", UNBOUNDED)
        require_known("base", self.base, BODIES, self.id)
        return BODIES[self.base]

    @property
    def return_bounds(self) -> tuple[float, float]:
        """The lowest and the highest return of an episode of any length up to the time limit."""
        rewards, longest = self.body.rewards, self.max_steps
        highest = max(rewards.high, rewards.high * longest) + rewards.end
        return min(rewards.low, rewards.low * longest), highest


PLANAR_BODIES = ("Hopper", "Walker2d", "HalfCheetah")
RUNNING_BODIES = (*PLANAR_BODIES, "Humanoid")
STANDING_UP_BODIES = ("HumanoidStandup", "HumanoidStandupAndRun")

GRAVITIES = {
    "GravityHalf": 0.5,
    "GravityThreeQuarters": 0.75,
    "GravityOneAndQuarter": 1.25,
    "GravityOneAndHalf": 1.5,
}
SIZES = {"Small": 0.75, "Big": 1.25}
LIMBS = ("Foot", "Leg", "Thigh", "Torso")
FURTHER_LIMBS = {"HalfCheetah": ("Head",), "Humanoid": ("Head", "Arm", "Hand")}
"""Parts beyond the four that every running body has. HalfCheetah's head is not in the paper's groups."""
WITHOUT_WALL = ("HumanoidStandup",)
"""Bodies with a wall width whose only published task has the wall parked."""


def _task(suffix: str, base: str, *variations: Variation) -> Task:
    return Task(f"{base}{suffix}", base, variations, max_steps=BODIES[base].max_steps)


def mujoco_tasks() -> list[Task]:
    """Every MuJoCo task. A body that no table names has one task, without variations."""
    walls = {body.name: variations.Wall(body.wall_width) for body in BODIES.values() if body.wall_width}
    tasks = [_task("", body) for body in RUNNING_BODIES]
    tasks += [
        _task(name, body, variations.Gravity(g)) for body in RUNNING_BODIES for name, g in GRAVITIES.items()
    ]
    tasks += [
        _task(f"{size}{part}", body, variations.LimbScale(part, factor))
        for body in RUNNING_BODIES
        for part in (*LIMBS, *FURTHER_LIMBS.get(body, ()))
        for size, factor in SIZES.items()
    ]
    tasks += [_task("", body) for body in STANDING_UP_BODIES]
    for body, wall in walls.items():
        tasks.append(_task("WithSensor", body, variations.RangeSensor(), replace(wall, parked=True)))
        if body not in WITHOUT_WALL:
            tasks.append(_task("Wall", body, variations.RangeSensor(), wall))
    tasks += [_task("", "Striker"), _task("MovingStart", "Striker", variations.MovingStart())]
    tasks += [_task("", "Pusher"), _task("MovingGoal", "Pusher", variations.MovingGoal())]
    # The paper announced motor noise, noisy sensors and moving goals for future releases.
    tasks += [_task("MotorNoise", body, variations.MotorNoise()) for body in RUNNING_BODIES]
    noisy = variations.SensorNoise()
    tasks += [
        _task("NoisyWall", body, variations.RangeSensor(), walls[body], noisy) for body in RUNNING_BODIES
    ]
    tasks.append(_task("TrackingGoal", "Pusher", variations.MovingGoal(), variations.TrackingGoal()))
    tasks.append(_task("TrackingGoal", "Striker", variations.TrackingGoal()))
    bases = {task.base for task in tasks if not task.variations}
    return tasks + [_task("", name) for name, body in BODIES.items() if body.asset and name not in bases]


MAPS, GOALS = range(10), range(3)

FAMILIES = {
    "state": "State-Based-Navigation-2d-Map{map}-Goal{goal}",
    "state-goal": "State-Based-Navigation-2d-Map{map}-Goal{goal}-KnownGoalPosition",
    "range": "Limited-Range-Based-Navigation-2d-Map{map}-Goal{goal}",
    "range-known": "Limited-Range-Based-Navigation-2d-Map{map}-Goal{goal}-KnownPositions",
    "image": "Image-Based-Navigation-2d-Map{map}-Goal{goal}",
}
"""The paper's task names by family. The tasks of one family have the same kind of observation."""


def navigation_tasks() -> list[Task]:
    """Every navigation task, family by family, then map by map, then goal by goal."""
    return [
        Task(pattern.format(map=number, goal=goal), "Navigation", (variations.Course(family, number, goal),))
        for family, pattern in FAMILIES.items()
        for number in MAPS
        for goal in GOALS
    ]


TASKS: dict[str, Task] = {each.id: each for each in (*mujoco_tasks(), *navigation_tasks())}
"""Every published task by its id."""


def tasks_by_base() -> dict[str, list[Task]]:
    """Every published task by the name of its base body, in the order of ``TASKS``."""
    bases: dict[str, list[Task]] = {}
    for each in TASKS.values():
        bases.setdefault(each.base, []).append(each)
    return bases


CHANGES: dict[str, str] = {}
"""What changed with each later version of a task, by its id."""


def versions(task: Task) -> dict[int, str]:
    """What changed with each version of a task up to its own."""
    later = range(1, task.version + 1)
    return {0: "first published version"} | {each: CHANGES[replace(task, version=each).id] for each in later}


def task(name: str) -> Task:
    """Returns the published task with that id or bare name.

    ``HopperGravityHalf`` is version 0, which groups contain, and ``HopperGravityHalf-v1`` version 1.

    Raises ``BenchError`` if no task has that name; the hint names the closest.
    """
    by_name = {each.bare_name: each for each in TASKS.values()}
    if found := TASKS.get(name) or by_name.get(name):
        return found
    other = "gym-extensions envs list names them. Ids of other packages have a version, such as Pendulum-v1."
    hint = did_you_mean(name, TASKS if "/" in name else by_name) or other
    raise BenchError("unknown-task", f"There is no task {name!r}.", hint=hint)


def definition(task: Task) -> dict[str, object]:
    """Returns the task as plain data, with the kind and the values of every variation."""
    return {
        "name": task.name,
        "version": task.version,
        "base": task.base,
        "max_steps": task.max_steps,
        "variations": [{"kind": type(each).__name__} | asdict(each) for each in task.variations],
    }


def from_definition(content: Mapping[str, Any]) -> Task:
    """Returns the task that ``definition`` describes.

    Raises:
        BenchError: a key, kind of variation or parameter is missing or unknown, or a value is invalid.
    """
    names = [field.name for field in fields(Task)]
    check_keys(content, names, names, "task")
    variations = tuple(make_variation(each, "task") for each in content["variations"])
    return Task(**{**content, "variations": variations})


def make_variation(table: object, where: str) -> Variation:
    """Returns the variation of a table such as ``{"kind": "Gravity", "factor": 0.5}``.

    Raises ``BenchError`` if the kind or a parameter is unknown, or a value is invalid.
    """
    if not isinstance(table, Mapping):
        hint = 'Write {kind = "Gravity", factor = 0.5}.'
        raise BenchError("malformed-group", f"The variation {table!r} is not a table.", where, hint)
    if "kind" not in table:
        raise BenchError("missing-key", "The key 'kind' is missing.", where, "Add kind.")
    require_known("variation", str(table["kind"]), KINDS, where)
    kind = KINDS[str(table["kind"])]
    parameters = {name: value for name, value in table.items() if name != "kind"}
    required = [field.name for field in fields(kind) if field.default is MISSING]
    names = [field.name for field in fields(kind)]
    check_keys(parameters, names, required, f"{where}, {table['kind']}")
    return kind(**parameters)


def check_keys(
    table: Mapping[str, object], names: Collection[str], required: Iterable[str], where: str
) -> None:
    """Raises ``BenchError`` for an unknown key, or a required key that is missing."""
    for key in table:
        require_known("key", key, names, where)
    for key in required:
        if key not in table:
            raise BenchError("missing-key", f"The key {key!r} is missing.", where, f"Add {key}.")


def _foreign_task(env_id: str, limit: int | None) -> Task:
    """Returns the task of an environment of another package. Imports Gymnasium.

    ``env_id`` is its id in Gymnasium's registry, with the version (``Pendulum-v1``); ``module:Name-v0``
    imports the module that registers it. ``limit`` replaces the registered time limit.

    Raises:
        BenchError: there is no such environment, or it has no time limit and none is given.
    """
    import gymnasium  # most users of the catalog need no registry

    module, _, name = env_id.rpartition(":")
    try:
        if module:
            importlib.import_module(module)
        registered = gymnasium.spec(name).max_episode_steps
    except Exception as error:  # the module may raise anything
        message = f"There is no task {env_id!r}: {str(error).rstrip('.')}."
        hint = "Install its package; name the module that registers it as in my_module:Name-v0."
        raise BenchError("unknown-task", message, hint=hint) from error
    limit = limit or registered
    if limit is None:
        raise BenchError("no-limit", f"{env_id} has no time limit.", hint="Give max_steps.")
    return Task(name if limit == registered else f"{name}.steps-{limit}", env_id, max_steps=limit)


def _task_named(name: str, limit: int | None) -> Task:
    """Returns the published task of that id or bare name, or the task of another package's environment."""
    name = name.removeprefix(f"{NAMESPACE}.envs:")  # which tells Gymnasium what to import
    is_ours = name.startswith(f"{NAMESPACE}/") or f"{NAMESPACE}/{name}" in TASKS
    return task(name) if is_ours or not GYMNASIUM_ID.fullmatch(name) else _foreign_task(name, limit)


def customize(
    task: str | Task, variations: Sequence[Variation] = (), *, max_steps: int | None = None
) -> Task:
    """Returns the task with more variations, another time limit, or both.

    If the result equals a published task, that published task is returned. Any other result has its
    parameters in its name (``Hopper.Gravity-0.8``), so it never carries the id of a published task.

    Args:
        task: an id (``gym_extensions/HopperGravityHalf-v0``), a bare name (``HopperGravityHalf``), a Task, or
            the id of any environment of Gymnasium's registry (``Pendulum-v1``), which takes no variations.
        variations: added after the task's own variations.
        max_steps: the time limit in environment steps; None keeps the task's.

    Raises:
        BenchError: the task is unknown, the time limit is below 1, or a value is not a variation.
    """
    limit = None if max_steps is None else whole_number("max_steps", max_steps, "bad-limit")
    added = _checked(variations)
    base = task if isinstance(task, Task) else _task_named(str(task), limit)
    steps = limit or base.max_steps
    if base.is_foreign:
        if added:
            message = f"{base.base} is an environment of another package, which takes no variations."
            raise BenchError("no-variation", message, hint="Register an id of your own with its changes.")
        return _foreign_task(base.base, steps)
    if not added and steps == base.max_steps:
        return base
    combined = (*base.variations, *added)
    ordered = sorted(combined, key=repr)
    for candidate in TASKS.values():
        has_rules = (candidate.base, candidate.max_steps) == (base.base, steps)
        if has_rules and sorted(candidate.variations, key=repr) == ordered:
            return candidate
    words = [base.name, *map(label, added), *([f"steps-{steps}"] if steps != base.max_steps else [])]
    return replace(base, name=".".join(words), variations=combined, max_steps=steps)


def label(variation: Variation) -> str:
    """The variation as a part of a task's name: its kind and values (``Gravity-0.8``), with m for a minus."""
    values = astuple(variation)
    words = (str(value).replace("-", "m") if isinstance(value, float) else str(value) for value in values)
    return re.sub(r"[^\w.]+", "-", "-".join([type(variation).__name__, *words])).strip("-")


def _checked(variations: object) -> tuple[Variation, ...]:
    if not isinstance(variations, Iterable):
        hint = "Give a list, even for one variation."
        raise BenchError("no-list", f"variations is {variations!r}.", hint=hint)
    added, hint = tuple(variations), "Give values such as Gravity(0.8)."
    for variation in added:
        if not isinstance(variation, Variation):
            raise BenchError("no-variation", f"{variation!r} is not a variation.", hint=hint)
    return added
