"""Tasks that are not published: any task with further variations or another time limit."""

from __future__ import annotations

import re
from dataclasses import astuple, replace

from gym_extensions.catalog.registry import TASKS
from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.base import Variation
from gym_extensions.errors import BenchError


def varied(task: Task, variations: tuple[Variation, ...] = (), max_steps: int | None = None) -> Task:
    """The task with the variations added after its own, and with another time limit if one is given.

    A result that is published under a name is that published task; any other has its parameters in its
    name, so that it never carries a published task's id (``Hopper.Gravity-0.8``).

    Raises:
        BenchError: the time limit is below 1, or something that is no variation is among them.
    """
    if max_steps is not None and (type(max_steps) is not int or max_steps < 1):
        raise BenchError("bad-limit", f"max_steps is {max_steps!r}.", hint="Give a whole number above 0.")
    for variation in variations:
        if not callable(getattr(variation, "apply", None)) or isinstance(variation, type):
            message = f"{variation!r} is no variation."
            raise BenchError("no-variation", message, hint="Give values such as Gravity(0.8).")
    steps = task.max_steps if max_steps is None else max_steps
    if not variations and steps == task.max_steps:
        return task
    together = (*task.variations, *variations)
    for known in TASKS.values():
        if (known.base, known.max_steps) == (task.base, steps) and _same(known.variations, together):
            return known
    words = [task.name, *map(label, variations), *([f"steps-{steps}"] if steps != task.max_steps else [])]
    return replace(task, name=".".join(words), variations=together, max_steps=steps)


def label(variation: Variation) -> str:
    """The variation as a word of a task's name: its kind and its values."""
    values = astuple(variation)  # type: ignore[call-overload]
    return re.sub(r"[^\w.]+", "-", "-".join([type(variation).__name__, *map(str, values)])).strip("-")


def _same(one: tuple[Variation, ...], other: tuple[Variation, ...]) -> bool:
    return sorted(map(repr, one)) == sorted(map(repr, other))
