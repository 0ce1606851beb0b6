"""A task describes one environment as data."""

from __future__ import annotations

from dataclasses import dataclass

from gym_extensions.catalog.bodies import Body, body
from gym_extensions.catalog.bodies.body import DEFAULT_MAX_STEPS
from gym_extensions.catalog.variations.base import Variation

NAMESPACE = "gym_extensions"


@dataclass(frozen=True)
class Task:
    """One environment as data.

    Args:
        name: the id without namespace and version, for example ``HopperGravityHalf``.
        base: the name of the base body.
        variations: what differs from the base body.
        version: increases whenever the task changes.
        max_steps: the time limit in environment steps.
    """

    name: str
    base: str
    variations: tuple[Variation, ...] = ()
    version: int = 0
    max_steps: int = DEFAULT_MAX_STEPS

    @property
    def id(self) -> str:
        """The Gymnasium id, for example ``gym_extensions/HopperGravityHalf-v0``."""
        return f"{NAMESPACE}/{self.name}-v{self.version}"

    @property
    def body(self) -> Body:
        """The row of the base body. Raises ``BenchError`` if no body has that name."""
        return body(self.base, self.id)

    @property
    def return_bounds(self) -> tuple[float, float]:
        """The lowest and the highest return of an episode of any length up to the time limit."""
        rewards = self.body.rewards
        lengths = (1, self.max_steps)
        highest = max(rewards.high * steps for steps in lengths) + rewards.end
        return min(rewards.low * steps for steps in lengths), highest
