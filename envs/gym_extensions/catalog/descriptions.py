"""The description of every published task: one text for ``envs show``, the documentation and the site.

`python -m tools.environments` writes it from the models into ``descriptions.json``; this module reads it and
loads no simulator. A description has the differences from the base body in words, the tables of actions and
observations, and what draws the task: a skeleton, or a map.
"""

import functools
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

import msgspec

from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.tasks import TASKS, Task, versions
from gym_extensions.errors import BenchError

PATH = Path(__file__).with_name("descriptions.json")
PICTURE = "uint8 picture, 120 rows × 160 columns × 3 colors, 4 units per pixel, y up"
"""The observation of a task whose table of observations is empty."""

FREE, SLIDE, HINGE = 0, 2, 3
"""Kinds of joints, as in MuJoCo."""
Role = Literal["body", "far", "changed", "object", "goal", "wall", "beam", "world-beam"]
"""What a shape is.

``far`` is a left limb, ``changed`` a part that differs from the base body. A ``beam`` turns with its link, a
``world-beam`` keeps its direction.
"""
Row = tuple[str, str, str, str]
"""A row of a table: index, meaning, unit and range."""


class Joint(NamedTuple):
    """A joint of a link: kind, index of its (first) coordinate, axis, anchor, and coordinate at rest."""

    kind: int
    coordinate: int
    axis: tuple[float, float, float]
    anchor: tuple[float, float, float]
    rest: float


class Shape(NamedTuple):
    """A capsule from ``start`` to ``end``, or a box with center ``start`` and half sizes ``end`` (a wall)."""

    role: Role
    radius: float
    start: tuple[float, float, float]
    end: tuple[float, float, float]


class Link(NamedTuple):
    """A body of the model: index of its parent (-1: the world), pose in it (m, quaternion), and content."""

    parent: int
    position: tuple[float, float, float]
    rotation: tuple[float, float, float, float]
    joints: tuple[Joint, ...]
    shapes: tuple[Shape, ...]


class Skeleton(NamedTuple):
    """The links of a body, parents first, and the azimuth and elevation of its view in degrees."""

    view: tuple[float, float]
    links: tuple[Link, ...]


Obstacle = tuple[int, int, int, int]
"""A rectangle of a map: x, y, width and height in units, y down."""


@dataclass(frozen=True)
class Description:
    """The facts of one task."""

    differences: tuple[str, ...]  # one sentence per variation; empty for a base body
    actions: tuple[Row, ...]  # the table of actions
    observations: tuple[Row, ...]  # the table of observations; empty for a picture
    skeleton: Skeleton | None = None  # what draws a body; None in 2-D navigation
    obstacles: tuple[Obstacle, ...] = ()  # of a map; empty for a body
    goal: tuple[float, float] | None = None  # the center of a map's goal in units, y down; None for a body


@dataclass(frozen=True)
class Field:
    """``count`` neighboring entries of a vector with the same meaning, unit and range."""

    meaning: str
    unit: str
    low: float = -math.inf
    high: float = math.inf
    count: int = 1
    is_soft: bool = False  # whether the range is a joint's limit, which an observation can exceed


class _TaskFacts(msgspec.Struct):
    """A task in the file. Tables, skeletons and maps that several tasks share are named by their index."""

    differences: tuple[str, ...]
    actions: int
    observations: int
    skeleton: int | None = None
    map: int | None = None
    goal: tuple[float, float] | None = None


class _Content(msgspec.Struct):
    maps: list[tuple[Obstacle, ...]]
    skeletons: list[Skeleton]
    tables: list[tuple[Row, ...]]
    tasks: dict[str, _TaskFacts]


@functools.cache
def descriptions() -> dict[str, Description]:
    """The description of every published task, by its id."""
    content, found = msgspec.json.decode(PATH.read_bytes(), type=_Content), {}
    for task_id, facts in content.tasks.items():
        tables = content.tables[facts.actions], content.tables[facts.observations]
        skeleton = None if facts.skeleton is None else content.skeletons[facts.skeleton]
        obstacles = () if facts.map is None else content.maps[facts.map]
        found[task_id] = Description(facts.differences, *tables, skeleton, obstacles, facts.goal)
    return found


def summary(task: Task) -> str:
    """Base, differences, reward, start, end, tables, groups, versions and fingerprint of a task as text.

    Raises ``BenchError`` if the task has no description.
    """
    facts = descriptions().get(task.id)
    if facts is None:
        raise BenchError(
            "no-description", "The task has no description.", task.id, "Run: python -m tools.environments"
        )
    prose = task.body.prose
    groups = [group.id for group in GROUPS.values() if task in group.tasks]
    rows = {
        "base": task.base,
        "what": prose.summary,
        "differs": " ".join(facts.differences) or "nothing",
        "reward": prose.reward,
        "start": prose.start,
        "end": prose.end,
        "time limit": f"{task.max_steps} steps",
        "success": task.body.success.sentence if task.body.success else "not defined",
        "source": prose.source,
        "groups": ", ".join(groups) or "none",
        "versions": "; ".join(f"v{number}: {text}" for number, text in versions(task).items()),
        "fingerprint": published(task.id),
    }
    lines = [task.id, *(f"  {name:<13}{value}" for name, value in rows.items())]
    lines += ["", *_text_table("action", facts.actions), ""]
    seen = facts.observations
    lines += _text_table("observation", seen) if seen else [f"observation: {PICTURE}"]
    return "\n".join(lines)


def _text_table(title: str, rows: tuple[Row, ...]) -> list[str]:
    lines = [("index", "meaning", "unit", "range"), *rows]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    cells = ([text.ljust(width) for text, width in zip(line, widths, strict=True)] for line in lines)
    count = int(rows[-1][0].rpartition("–")[2]) + 1
    return [f"{title} ({count} numbers)", *("  " + "  ".join(line).rstrip() for line in cells)]


def picture_file(task: Task) -> str:
    """Returns the file name of the picture of a task; empty in 2-D navigation, whose maps are drawn.

    It is the picture of the published task with those of its variations that are seen, if there is one.

    Example:
        >>> from gym_extensions.catalog.tasks import task
        >>> picture_file(task("HopperGravityHalf")), picture_file(task("HopperBigFoot"))
        ('hopper.webp', 'hopperbigfoot.webp')
    """
    if task.body.camera is None:
        return ""
    seen = task.base, tuple(each for each in task.variations if each.shows)
    same = (each for each in TASKS.values() if (each.base, each.variations) == seen)
    return f"{next(same, task).bare_name.lower()}.webp"
