"""The columns of the table of base bodies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from gym_extensions.catalog.bodies.success import Success

Family = Literal["planar", "humanoid", "arm", "navigation"]
"""Bodies of one family share the layout of their observations."""
Frame = Literal["pitch", "torso", "world"]
"""The frame in which range beams are fixed: the planar root, the free torso, or the world."""
DEFAULT_MAX_STEPS = 1000


@dataclass(frozen=True)
class Segments:
    """How an episode is cut into segments that replay on another machine.

    A segment has ``steps`` environment steps. Its replay may differ by ``tolerance``, absolute and relative.

    The length is chosen by measurement. Between two math libraries, whole HalfCheetah episodes drift apart;
    segments of 25 steps miss 1e-6 once in 936; at 10 steps the worst difference is 2e-9. The contacts of
    Pusher and Striker need at most 5 steps.
    """

    steps: int = 10
    tolerance: float = 1e-6


@dataclass(frozen=True)
class RewardBounds:
    """Lowest and highest reward per step.

    ``terminates`` is False if only the time limit ends an episode. ``end`` is added once, by the step that
    terminates the episode.
    """

    low: float
    high: float
    terminates: bool = True
    end: float = 0.0


UNBOUNDED = RewardBounds(-1e6, 1e6)
"""Bounds for a task that is not known."""


@dataclass(frozen=True)
class Prose:
    """The text about a body in the documentation."""

    summary: str
    reward: str
    start: str
    end: str
    source: str


@dataclass(frozen=True)
class Camera:
    """The camera of a body's picture.

    It looks at the point (x, 0, z), in m, from ``distance`` m; azimuth and elevation are in degrees. A body
    is shown in its rest pose, or after a reset with seed 0 if ``after_reset``.
    """

    x: float
    z: float
    distance: float
    azimuth: float
    elevation: float
    after_reset: bool = False


@dataclass(frozen=True)
class Feet:
    """Two feet that would touch in the rest pose if they were bigger.

    ``distance`` is between their centers, in m.
    """

    names: tuple[str, str]
    distance: float


@dataclass(frozen=True)
class Rectangle:
    """An axis-aligned rectangle, lower and upper corner in m."""

    low: tuple[float, float]
    high: tuple[float, float]


@dataclass(frozen=True)
class Body:
    """One base body.

    Args:
        name: the name in tasks, for example ``HalfCheetah``.
        family: bodies of one family share the layout of their observations.
        asset: file name of the model among Gymnasium's MuJoCo assets; empty without a model.
        model_name: the name that the model file gives the model; empty without a model.
        prose: what the documentation says.
        rewards: bounds of the reward.
        camera: the camera of the documentation's picture; None without a picture.
        segments: how episodes are cut for replay.
        max_steps: default time limit in environment steps.
        parts: the geoms of every part that ``LimbScale`` can change, by part.
        feet: feet whose contact is excluded when ``LimbScale`` makes them overlap.
        has_gravity: whether the model has gravity.
        beams: the frame of the range beams; None if the body has no torso to carry them.
        wall_width: width of the published wall in m; None without a wall task.
        velocity_limit: Gymnasium clips observed velocities to this magnitude; None for no limit.
        goal_area: the rectangle within which a moving goal stays; None without a goal.
        success: when an episode is a success; None if its tasks define no success.
    """

    name: str
    family: Family
    asset: str
    model_name: str
    prose: Prose
    rewards: RewardBounds
    camera: Camera | None = None
    segments: Segments = Segments()
    max_steps: int = DEFAULT_MAX_STEPS
    parts: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    feet: Feet | None = None
    has_gravity: bool = True
    beams: Frame | None = None
    wall_width: float | None = None
    velocity_limit: float | None = None
    goal_area: Rectangle | None = None
    success: Success | None = None


def gymnasium_source(file: str) -> str:
    """The sentence that names the Gymnasium class a body comes from."""
    return f"Gymnasium 1.4, `gymnasium/envs/mujoco/{file}.py`, default arguments."


def uniform_start(model: str, noise: str) -> str:
    """The sentence for a start at the rest pose with uniform noise."""
    return f"{model}'s rest pose. Noise from U(−{noise}, {noise}) is added to every position and velocity."


TIME_LIMIT_ONLY = "Only at the time limit."
