"""Every task as a row of a table: a name, a base body, what differs from it, a version."""

from __future__ import annotations

from dataclasses import dataclass

from gym_extensions.catalog.errors import BenchError, did_you_mean
from gym_extensions.catalog.variations import Gravity, Variation

NAMESPACE = "gym_extensions"


@dataclass(frozen=True)
class Task:
    """One environment as data. ``base`` names the body that is built, ``max_steps`` ends an episode."""

    name: str
    base: str
    variations: tuple[Variation, ...] = ()
    version: int = 0
    max_steps: int = 1000

    @property
    def id(self) -> str:
        """The Gymnasium id, for example ``gym_extensions/HopperGravityHalf-v0``."""
        return f"{NAMESPACE}/{self.name}-v{self.version}"


RUNNING_BODIES = ("Hopper", "Walker2d", "HalfCheetah", "Humanoid")
GRAVITIES = {
    "GravityHalf": 0.5,
    "GravityThreeQuarters": 0.75,
    "GravityOneAndQuarter": 1.25,
    "GravityOneAndHalf": 1.5,
}


def _running() -> list[Task]:
    return [Task(body, body) for body in RUNNING_BODIES]


def _gravity() -> list[Task]:
    return [
        Task(f"{body}{suffix}", body, (Gravity(factor),))
        for body in RUNNING_BODIES
        for suffix, factor in GRAVITIES.items()
    ]


TASKS: dict[str, Task] = {task.id: task for task in (*_running(), *_gravity())}
"""Every published task by its id."""


def task(name: str) -> Task:
    """The published task of that id, or of its bare name (``HopperGravityHalf``).

    Raises:
        BenchError: there is no such task; the hint names the closest.
    """
    by_name = {known.name: known for known in TASKS.values()}
    found = TASKS.get(name) or by_name.get(name)
    if found is None:
        choices = TASKS if "/" in name else by_name
        raise BenchError("unknown-task", f"There is no task {name!r}.", hint=did_you_mean(name, choices))
    return found
