"""Which tasks run on arrays, and which environments can share a shard."""

from __future__ import annotations

from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.base import RuntimeVariation
from gym_extensions.envs.bodies import IMPLEMENTATIONS, implementation
from gym_extensions.envs.effects.registry import RUNTIME_VARIATIONS, shard_keys
from gym_extensions.envs.rules.base import RulesFactory
from gym_extensions.envs.vector.template import TaskTemplate

LAYOUT = (
    *("nq", "nv", "nu", "na", "nbody", "njnt", "ngeom", "nsite", "ncam", "nlight", "nmesh", "nmocap"),
    *("neq", "ntendon", "nsensor", "nsensordata", "nuserdata", "nplugin"),
)
"""Sizes of MjModel that the simulations of one batch have in common."""


def is_vectorized(task: Task) -> bool:
    """Returns whether there are rules on arrays for the task's body and all of its variations."""
    unknown = any(
        isinstance(variation, RuntimeVariation) and not isinstance(variation, RUNTIME_VARIATIONS)
        for variation in task.variations
    )
    return task.base in IMPLEMENTATIONS and implementation(task.base).rules is not None and not unknown


def rules_of(template: TaskTemplate) -> RulesFactory:
    """Returns the rules of a template's body. Raises ``ValueError`` if it has none."""
    rules = implementation(template.task.base).rules
    if rules is None:
        raise ValueError(f"{template.task.base} has no rules on arrays")
    return rules


def layout(template: TaskTemplate) -> tuple[object, ...]:
    """Returns the rules, effects and model sizes that the environments of a shard share."""
    task, model = template.task, template.model
    sizes = tuple(int(getattr(model, name)) for name in LAYOUT)
    return task.base, task.max_steps, template.frame_skip, model.opt.timestep, sizes, shard_keys(task)
