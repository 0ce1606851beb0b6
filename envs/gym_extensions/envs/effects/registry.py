"""The effects of a task's variations.

Every module of this package is one effect and defines ``KIND``, except those of ``WITHOUT_KIND``.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections import Counter
from collections.abc import Iterator, Sequence

from gym_extensions.catalog.bodies import BODIES
from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.goals import MovingGoal, MovingStart
from gym_extensions.envs import effects
from gym_extensions.envs.effects.base import Effect, EffectKind, VectorEffect, variation_of
from gym_extensions.envs.protocols import Physics, Template
from gym_extensions.errors import BenchError

WITHOUT_KIND = ("base", "registry", "seeded_noise")


def _discover() -> Iterator[EffectKind]:
    for module in pkgutil.iter_modules(effects.__path__):
        if module.name not in WITHOUT_KIND:
            yield importlib.import_module(f"{effects.__name__}.{module.name}").KIND


KINDS: tuple[EffectKind, ...] = tuple(sorted(_discover(), key=lambda kind: kind.draw_order))
"""Every kind of effect, in the order in which effects draw at reset."""

RUNTIME_VARIATIONS = (*(kind.variation for kind in KINDS), MovingGoal, MovingStart)
"""Variations that act at run time; the last two act in the arms' own resets."""


def kinds_of(task: Task) -> list[EffectKind]:
    """Returns the kinds of effects of a task, without those that another kind replaces."""
    kinds = [kind for kind in KINDS if variation_of(task, kind.variation) is not None]
    replaced = {kind.replaces for kind in kinds}
    return [kind for kind in kinds if kind.variation not in replaced]


def effects_of(task: Task) -> list[Effect]:
    """Returns the effects of a task on one environment, in the order in which they draw.

    Raises:
        BenchError: a variation does not fit the base body, appears twice, or lacks the one it replaces.
    """
    check_variations(task)
    return [kind.single(task) for kind in kinds_of(task)]


def vector_effects_of(physics: Physics, templates: Sequence[Template]) -> list[VectorEffect]:
    """Returns the effects on the environments of one shard, in the order in which they draw."""
    return [kind.vector(physics, templates) for kind in kinds_of(templates[0].task)]


def shard_keys(task: Task) -> tuple[object, ...]:
    """Returns what environments of one shard have in common in their effects."""
    variations = [(kind, variation_of(task, kind.variation)) for kind in KINDS]
    return tuple(None if variation is None else kind.shard_key(variation) for kind, variation in variations)


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
