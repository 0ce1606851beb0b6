"""What a task is."""

from __future__ import annotations

from dataclasses import dataclass

from gym_extensions.catalog.variations.base import Variation

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
