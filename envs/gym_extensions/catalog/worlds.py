"""Worlds between and beyond the tasks of a group: the same body along the quantity that the group varies.

Worlds are not published tasks: they have no Gymnasium id, no references, and nothing is trained on them.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

from gym_extensions.catalog import groups, tasks, variations

Place = Literal["trained", "between", "beyond"]
"""Where a value lies: trained on, between trained values, or outside of them."""


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
    base: tasks.Task  # the tasks without what varies
    at: Callable[[float], variations.Variation]  # the variation with a value

    def world(self, value: float) -> tasks.Task:
        """The task at a value."""
        variation = self.at(value)
        name = f"{self.base.name}.{tasks.label(variation)}"
        return replace(self.base, name=name, variations=(*self.base.variations, variation))

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


def axes(group: groups.TaskGroup) -> tuple[Axis, ...]:
    """The axes of a group: gravity, the scale of each part of the body, or the distance of the wall.

    A group has axes if each of its tasks differs from their common base in the quantity of one kind of
    variation alone. Others have none: navigation, arms, motor noise, custom groups of several kinds. A task
    without that variation trains on the base body's value; a parked wall trains on none.
    """
    bases: set[tasks.Task] = set()
    kinds: set[type[variations.Variation]] = set()
    varied: dict[str, dict[int, variations.Quantity]] = {}
    for index, task in enumerate(group.tasks):
        measured = {each: each.quantity for each in task.variations if each.quantity is not None}
        if len(measured) > 1:
            return ()
        unmeasured = tuple(each for each in task.variations if each not in measured)
        bases.add(replace(task, name=task.base, variations=unmeasured, version=0))
        for variation, quantity in measured.items():
            kinds.add(type(variation))
            varied.setdefault(quantity.name, {})[index] = quantity
    if len(bases) != 1 or len(kinds) != 1:
        return ()
    (base,) = bases
    plain = set(range(len(group.tasks))).difference(*varied.values())
    found = []
    for name, by_task in varied.items():
        first, *others = by_task.values()
        if any(each.at(first.points[0]) != first.at(first.points[0]) for each in others):
            return ()  # they differ in more than the quantity
        values = {index: each.trained for index, each in by_task.items()}
        if first.unchanged is not None:
            values |= dict.fromkeys(plain, (first.unchanged, first.unchanged))
        elif plain:
            return ()
        trained = tuple(Trained(index, *ends) for index, ends in sorted(values.items()) if ends)
        if trained:
            found.append(Axis(name, first.title, first.unit, first.points, trained, base, first.at))
    return tuple(found)
