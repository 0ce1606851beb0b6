"""The effects of a task's variations."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from gym_extensions.catalog.bodies import BODIES
from gym_extensions.catalog.tasks import Task
from gym_extensions.envs.effects import motors_and_goals, wall_and_sensor
from gym_extensions.envs.effects.base import Effect, EffectKind, variation_of
from gym_extensions.envs.interfaces import Fields, Template
from gym_extensions.errors import BenchError

KINDS: tuple[EffectKind, ...] = (*wall_and_sensor.KINDS, *motors_and_goals.KINDS)
"""Every kind of effect, in the order in which effects draw at reset; a new kind is the last."""


def effects_of(fields: Fields, templates: Sequence[Template]) -> list[Effect]:
    """Returns the effects on environments with one layout, in the order in which they draw."""
    kinds = [kind for kind in KINDS if variation_of(templates[0].task, kind.variation) is not None]
    replaced = {kind.replaces for kind in kinds}
    return [kind.effect(fields, templates) for kind in kinds if kind.variation not in replaced]


def shard_keys(task: Task) -> tuple[object, ...]:
    """Returns what environments of one shard have in common in their effects."""
    pairs = [(kind, variation_of(task, kind.variation)) for kind in KINDS]
    return tuple(None if variation is None else kind.shard_key(variation) for kind, variation in pairs)


def check_variations(task: Task) -> None:
    """Checks that the variations fit the base body and each other.

    Raises:
        BenchError: a variation does not fit the base body, appears twice, or lacks the one it replaces.
    """
    for variation in task.variations:
        fits = getattr(variation, "fits", None)
        if fits is not None and not fits(task.body):
            message = f"{type(variation).__name__} does not fit {task.base}."
            fitting = ", ".join(body.name for body in BODIES.values() if fits(body))
            raise BenchError("misplaced-variation", message, task.id, f"It fits {fitting}.")
    counts = Counter(type(variation) for variation in task.variations)
    for kind in KINDS:
        name = kind.variation.__name__
        if counts[kind.variation] > 1:
            message = f"The variation {name} is given {counts[kind.variation]} times."
            raise BenchError("repeated-variation", message, task.id, "Give it once.")
        if kind.replaces is not None and counts[kind.variation] > counts[kind.replaces]:
            needed = kind.replaces.__name__
            message, hint = f"{name} needs a {needed}.", f"Add {needed}()."
            raise BenchError("missing-variation", message, task.id, hint)
