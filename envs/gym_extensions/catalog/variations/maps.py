"""The map, goal and observation of a navigation task."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from gym_extensions.errors import BenchError

if TYPE_CHECKING:
    import mujoco


@dataclass(frozen=True)
class Course:
    """What makes one navigation task: what the agent observes, on which map, to which goal."""

    family: str
    map: int
    goal: int

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Raises ``BenchError``: a course is no change of a body."""
        hint = "Make a navigation task by its name."
        raise BenchError(
            "not-a-body-variation", "A course on a map cannot be added to a body.", str(self), hint
        )
