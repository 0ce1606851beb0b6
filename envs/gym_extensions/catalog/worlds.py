"""Worlds between and beyond the tasks of a group: the same body along the quantity that the group varies.

Worlds are not published tasks: they have no Gymnasium id, no references, and nothing is trained on them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.tasks import Task, label
from gym_extensions.catalog.variations import Gravity, LimbScale, Wall

Place = Literal["trained", "between", "beyond"]
"""Where a value lies: trained on, between trained values, or outside of them."""
GRAVITIES = (0.3, 0.35, 0.4, 0.5, 0.625, 0.75, 0.875, 1.0, 1.125, 1.25, 1.375, 1.5, 1.6, 1.65, 1.7)
"""Factors of gravity: the five of the tasks, the middles between them, and three at each end."""
SCALES = (0.6, 0.675, 0.75, 0.875, 1.0, 1.125, 1.25, 1.325, 1.4)
"""Factors of the width and mass of a part of the body."""
DISTANCES = (1.2, 1.4, 1.6, 1.8, 2.3, 2.8, 3.3, 3.8, 4.2, 4.6, 5.0)
"""Distances of the wall's center from the start, in m."""


@dataclass(frozen=True)
class Trained:
    """The values on which a task of the group trains: its index in the group, the lowest and the highest."""

    task: int
    low: float
    high: float


@dataclass(frozen=True)
class Axis:
    """A quantity that a group varies, and the values at which its policies are measured."""

    name: str  # short, in lower case; unique in the group
    title: str  # what varies, in words
    unit: str
    points: tuple[float, ...]  # the values, ascending
    trained: tuple[Trained, ...]  # what the tasks of the group train on, in training order
    world: Callable[[float], Task]  # the task at a value

    def place(self, value: float) -> Place:
        """Where a value lies."""
        if any(each.low <= value <= each.high for each in self.trained):
            return "trained"
        is_inside = min(each.low for each in self.trained) < value < max(each.high for each in self.trained)
        return "between" if is_inside else "beyond"

    def indices(self, place: Place) -> tuple[int, ...]:
        """The indices of the points in that place."""
        return tuple(index for index, value in enumerate(self.points) if self.place(value) == place)

    def nearest(self, value: float) -> int:
        """The index of the task with the nearest trained value; of two, the one trained first.

        An agent that observes the task observes this one.
        """
        return min(self.trained, key=lambda each: max(each.low - value, value - each.high, 0.0)).task


def axes(group: TaskGroup) -> tuple[Axis, ...]:
    """The axes of a group: gravity, the scale of each part of the body, or the distance of the wall.

    A group has axes if each of its tasks differs from their common base in that quantity alone. Others have
    none: navigation, arms, motor noise, custom groups of several kinds.
    """
    found: dict[str, list[Trained]] = {}
    bases: dict[str, set[Task]] = {}
    for index, task in enumerate(group.tasks):
        if (part := _part(task)) is None:
            return ()
        name, base, low, high = part
        bases.setdefault(name, set()).add(base)
        if high:
            found.setdefault(name, []).append(Trained(index, low, high))
    if len(set().union(*bases.values())) != 1 or ("gravity" in found and len(found) > 1):
        return ()
    return tuple(_axis(name, tuple(trained), *bases[name]) for name, trained in found.items())


def _part(task: Task) -> tuple[str, Task, float, float] | None:
    """The axis of a task, the task without what varies, and the values on which it trains; else None.

    A parked wall trains on no distance: its values are 0.
    """
    if task.is_foreign or task.body.family == "navigation":
        return None
    varied = [each for each in task.variations if isinstance(each, Gravity | LimbScale | Wall)]
    others = tuple(each for each in task.variations if each not in varied)
    base = replace(task, name=task.base, variations=others, version=0)
    match varied:
        case []:
            return ("gravity", base, 1.0, 1.0) if not others else None
        case [Gravity(factor)]:
            return "gravity", base, factor, factor
        case [LimbScale(part, factor)]:
            return part.lower(), base, factor, factor
        case [Wall() as wall]:
            base = replace(base, variations=(*others, replace(wall, parked=False)))
            return "wall", base, *((0.0, 0.0) if wall.parked else (wall.nearest, wall.farthest))
    return None


def _axis(name: str, trained: tuple[Trained, ...], base: Task) -> Axis:
    if name == "gravity":
        return Axis(name, "gravity", "g", GRAVITIES, trained, lambda value: _with(base, Gravity(value)))
    if name == "wall":
        return Axis(name, "distance of the wall", "m", DISTANCES, trained, lambda at: _at(base, at))
    title, part = f"width and mass of the {name}", name.capitalize()
    return Axis(name, title, "×", SCALES, trained, lambda value: _with(base, LimbScale(part, value)))


def _with(base: Task, variation: Gravity | LimbScale) -> Task:
    return replace(base, name=f"{base.name}.{label(variation)}", variations=(*base.variations, variation))


def _at(base: Task, distance: float) -> Task:
    """The task with its wall at one distance."""
    variations = tuple(
        replace(each, nearest=distance, farthest=distance) if isinstance(each, Wall) else each
        for each in base.variations
    )
    return replace(base, name=f"{base.name}.Wall-{distance:g}", variations=variations)
