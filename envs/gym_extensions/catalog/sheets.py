"""Facts of every published task that follow from its model, read from ``sheets.json`` without a simulator.

`gym-extensions envs docs` writes the file. A sheet has the differences from the base body in words, the
tables of actions and observations, and what draws the task: a skeleton, or a map.
"""

from __future__ import annotations

import functools
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple

PATH = Path(__file__).with_name("sheets.json")

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


@dataclass(frozen=True)
class Sheet:
    """The facts of one task.

    Args:
        differences: one sentence per variation; empty for a base body.
        actions: rows of the table of actions.
        observations: rows of the table of observations; empty for a picture.
        skeleton: what draws a body; None in 2-D navigation.
        obstacles: rectangles (x, y, width, height) of a map in units, y down; empty for a body.
        goal: the center of a map's goal in units, y down; None for a body.
    """

    differences: tuple[str, ...]
    actions: tuple[Row, ...]
    observations: tuple[Row, ...]
    skeleton: Skeleton | None = None
    obstacles: tuple[tuple[int, int, int, int], ...] = ()
    goal: tuple[float, float] | None = None


@functools.cache
def _content() -> Mapping[str, Any]:
    content: dict[str, Any] = json.loads(PATH.read_text(encoding="utf-8"))
    return content


@functools.cache
def sheet(task_id: str) -> Sheet | None:
    """The sheet of a published task, or None if the task has none."""
    content = _content()
    row = content["tasks"].get(task_id)
    if row is None:
        return None
    skeleton, number = row.get("skeleton"), row.get("map")
    return Sheet(
        differences=tuple(row["differences"]),
        actions=tuple(map(tuple, content["tables"][row["actions"]])),
        observations=tuple(map(tuple, content["tables"][row["observations"]])),
        skeleton=None if skeleton is None else _skeleton(content["skeletons"][skeleton]),
        obstacles=() if number is None else tuple(map(tuple, content["maps"][number])),
        goal=tuple(row["goal"]) if "goal" in row else None,
    )


def _skeleton(value: Any) -> Skeleton:
    view, links = value
    return Skeleton(
        tuple(view),
        tuple(
            Link(parent, tuple(position), tuple(rotation), _rows(Joint, joints), _rows(Shape, shapes))
            for parent, position, rotation, joints, shapes in links
        ),
    )


def _rows(kind: Any, rows: Any) -> tuple[Any, ...]:
    return tuple(kind(*(tuple(item) if isinstance(item, list) else item for item in row)) for row in rows)
