"""Which rules each base body follows."""

from __future__ import annotations

from gym_extensions.catalog.tasks import Task
from gym_extensions.envs.batching.humanoid import HumanoidRules
from gym_extensions.envs.batching.planar import Planar
from gym_extensions.envs.batching.rules import MakesRules

FAMILIES: dict[str, MakesRules] = {
    "Hopper": Planar,
    "Walker2d": Planar,
    "HalfCheetah": Planar,
    "Humanoid": HumanoidRules,
}
"""The rules of every base body."""


def family(task: Task) -> MakesRules:
    """The rules that the task's lanes follow."""
    return FAMILIES[task.base]
