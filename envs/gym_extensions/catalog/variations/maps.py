"""The map, goal and observation of a navigation task."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from gym_extensions.catalog.variations.base import BaseVariation
from gym_extensions.errors import BenchError

if TYPE_CHECKING:
    import mujoco

    from gym_extensions.catalog.bodies.body import Body


@dataclass(frozen=True)
class Course(BaseVariation):
    """One navigation task, with the observation family and the numbers of the map and the goal."""

    family: str
    map: int
    goal: int

    @classmethod
    def fits(cls, body: Body) -> bool:
        """Returns whether the body is the point of navigation."""
        return body.family == "navigation"

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Raises ``BenchError``, because a course does not change a model."""
        hint = "Make a navigation task by its name."
        message = "A navigation course cannot be added to a MuJoCo body."
        raise BenchError("not-a-body-variation", message, str(self), hint)
