"""Goals and balls that start at random positions, and goals that move."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from gym_extensions.catalog.variations.base import RuntimeVariation, set_positive
from gym_extensions.errors import BenchError

if TYPE_CHECKING:
    import mujoco

    from gym_extensions.catalog.bodies.body import Body


MAX_SPEED = 4.0
"""Largest speed of a moving goal, in m/s: 0.2 m, the shortest side of a rectangle, per step of 0.05 s."""


@dataclass(frozen=True)
class MovingGoal(RuntimeVariation):
    """Draws Pusher's goal at every reset, then the object away from it (the paper's PusherMovingGoal)."""

    @classmethod
    def fits(cls, body: Body) -> bool:
        """Returns whether the body is Pusher."""
        return body.name == "Pusher"

    def describe(self, body: Body, spec: mujoco.MjSpec) -> str:
        """Returns the documentation's sentence."""
        return (
            "The goal is drawn at reset, at offsets y ~ U(−0.2, 0), x ~ U(−0.1, 0.3) from (0.45, −0.05). "
            "The object is then drawn until its distance from the goal exceeds 0.17 m."
        )


@dataclass(frozen=True)
class MovingStart(RuntimeVariation):
    """Draws Striker's ball at every reset, then the goal away from it (the paper's StrikerMovingStart)."""

    @classmethod
    def fits(cls, body: Body) -> bool:
        """Returns whether the body is Striker."""
        return body.name == "Striker"

    def describe(self, body: Body, spec: mujoco.MjSpec) -> str:
        """Returns the documentation's sentence."""
        return (
            "The ball is drawn at reset, x ~ U(0.43, 0.55), y ~ U(−0.3, −0.05). The goal is drawn again "
            "while it is within 0.17 m of the ball."
        )


@dataclass(frozen=True)
class TrackingGoal(RuntimeVariation):
    """Moves the goal during the episode, at a velocity drawn at reset, inside a rectangle.

    The goal is reflected at the edges of the rectangle from which its start is drawn. ``speed`` bounds each
    component of the velocity, in m/s.
    """

    speed: float = 0.2

    def __post_init__(self) -> None:
        set_positive(self, "speed")
        if self.speed > MAX_SPEED:
            hint = f"Give at most {MAX_SPEED:g}, with which a goal crosses its rectangle in one step."
            raise BenchError("bad-factor", f"TrackingGoal's speed is {self.speed!r}.", hint=hint)

    @classmethod
    def fits(cls, body: Body) -> bool:
        """Returns whether the body has a goal that can move."""
        return body.goal_area is not None

    def describe(self, body: Body, spec: mujoco.MjSpec) -> str:
        """Returns the documentation's sentence."""
        return (
            f"The goal moves during the episode. Its velocity components are drawn at reset from "
            f"U(−{self.speed:g}, {self.speed:g}) m/s, and it is reflected at the edges of the rectangle from "
            "which its start is drawn."
        )
