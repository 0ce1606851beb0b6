"""Custom tasks: a published task with further variations or another time limit."""

from __future__ import annotations

import operator
import re
from collections.abc import Iterable, Sequence
from dataclasses import astuple, is_dataclass, replace
from typing import Any

from gym_extensions.catalog.registry import TASKS
from gym_extensions.catalog.registry import task as published_task
from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.base import Variation
from gym_extensions.errors import BenchError


def customize(
    task: str | Task, variations: Sequence[Variation] = (), *, max_steps: int | None = None
) -> Task:
    """Returns the task with more variations, another time limit, or both.

    If the result equals a published task, that published task is returned. Any other result has its
    parameters in its name (``Hopper.Gravity-0.8``), so it never carries the id of a published task.

    Args:
        task: an id (``gym_extensions/HopperGravityHalf-v0``), a bare name (``HopperGravityHalf``), or a Task.
        variations: added after the task's own variations.
        max_steps: the time limit in environment steps; None keeps the task's.

    Raises:
        BenchError: the task is unknown, the time limit is below 1, or a value is not a variation.
    """
    base = task if isinstance(task, Task) else published_task(task)
    limit = _limit(max_steps)
    added = _checked(variations)
    steps = base.max_steps if limit is None else limit
    if not added and steps == base.max_steps:
        return base
    combined = (*base.variations, *added)
    for candidate in TASKS.values():
        same_base = (candidate.base, candidate.max_steps) == (base.base, steps)
        if same_base and _same(candidate.variations, combined):
            return candidate
    words = [base.name, *map(label, added), *([f"steps-{steps}"] if steps != base.max_steps else [])]
    return replace(base, name=".".join(words), variations=combined, max_steps=steps)


def label(variation: Variation) -> str:
    """The variation as a part of a task's name: its kind and values (``Gravity-0.8``), with m for a minus."""
    values: tuple[object, ...] = astuple(variation) if is_dataclass(variation) else ()
    words = (str(value).replace("-", "m") if isinstance(value, float) else str(value) for value in values)
    return re.sub(r"[^\w.]+", "-", "-".join([type(variation).__name__, *words])).strip("-")


def _limit(max_steps: Any) -> int | None:
    if max_steps is None:
        return None
    try:
        limit = 0 if isinstance(max_steps, bool) else operator.index(max_steps)
    except TypeError:
        limit = 0
    if limit < 1:
        raise BenchError("bad-limit", f"max_steps is {max_steps!r}.", hint="Give a whole number above 0.")
    return limit


def _checked(variations: Any) -> tuple[Variation, ...]:
    if not isinstance(variations, Iterable):
        hint = "Give a list, even for one variation."
        raise BenchError("no-list", f"variations is {variations!r}.", hint=hint)
    added = tuple(variations)
    for variation in added:
        if not callable(getattr(variation, "apply", None)) or isinstance(variation, type):
            message = f"{variation!r} is not a variation."
            raise BenchError("no-variation", message, hint="Give values such as Gravity(0.8).")
    return added


def _same(first: tuple[Variation, ...], second: tuple[Variation, ...]) -> bool:
    return sorted(map(repr, first)) == sorted(map(repr, second))
