"""A wall in the way, the range sensor that sees it, and noise on that sensor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from gym_extensions.catalog.variations.base import (
    BaseVariation,
    RuntimeVariation,
    finite,
    set_positive,
)
from gym_extensions.errors import BenchError

if TYPE_CHECKING:
    import mujoco

    from gym_extensions.catalog.bodies.body import Body

WALL = "wall"
"""Name of the wall's body and geom in the model."""
PARKED_HEIGHT = -100.0
"""z of a parked wall's center, in m: no body and no beam reaches that far below the floor."""
BOX = 6
"""MuJoCo's mjGEOM_BOX; the catalog loads no simulator."""


@dataclass(frozen=True)
class Wall(BaseVariation):
    """A box across the way, its center at y = 0 and at x drawn from U(nearest, farthest) at every reset.

    The box is a mocap body, added last to the world, without mass and friction. Lengths are in m. A parked
    wall is out of reach under the floor, so that its task shares the model layout of the task with the wall.
    """

    width: float = 0.8
    depth: float = 0.4
    height: float = 0.5
    centre_height: float = 0.125
    nearest: float = 1.8
    farthest: float = 3.8
    parked: bool = False

    def __post_init__(self) -> None:
        set_positive(self, "width", "depth", "height", "nearest", "farthest")
        height = finite(self.centre_height)
        if height is None:
            message = f"Wall's centre_height is {self.centre_height!r}."
            raise BenchError("bad-height", message, hint="Give a finite number.")
        object.__setattr__(self, "centre_height", height)
        if not isinstance(self.parked, bool):
            raise BenchError("bad-value", f"Wall's parked is {self.parked!r}.", hint="Give true or false.")
        if not self.farthest >= self.nearest:
            message = f"Wall's farthest is {self.farthest!r} and its nearest {self.nearest!r}."
            raise BenchError("bad-range", message, hint="Give farthest at least as large as nearest.")

    @classmethod
    def fits(cls, body: Body) -> bool:
        """Returns whether the body moves along x."""
        return body.beams is not None

    @property
    def half_sizes(self) -> tuple[float, float, float]:
        """Half of the box's depth (x), width (y) and height (z), m."""
        return self.depth / 2, self.width / 2, self.height / 2

    @property
    def rest(self) -> tuple[float, float, float]:
        """The center in the model, in m, before a reset draws its x."""
        if self.parked:
            return 0.0, 0.0, PARKED_HEIGHT
        return (self.nearest + self.farthest) / 2, 0.0, self.centre_height

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Adds the box and keeps the model's extent and center, or the renderer would clip the agent.

        A contact takes the larger condim of its two geoms. Priority 1 gives the wall's condim 1, that is, no
        friction.
        """
        before = spec.copy().compile().stat
        spec.stat.extent, spec.stat.center = before.extent, before.center
        body = spec.worldbody.add_body(name=WALL, mocap=True, pos=self.rest)
        body.add_geom(
            name=WALL,
            type=BOX,
            size=self.half_sizes,
            mass=0,
            contype=1,
            conaffinity=1,
            condim=1,
            priority=1,
            material="",
            rgba=(0.75, 0.25, 0.55, 1),
        )

    def describe(self, body: Body, spec: mujoco.MjSpec) -> str:
        """Returns the documentation's sentence."""
        size = f"{self.depth:g} × {self.width:g} × {self.height:g} m (depth × width × height)"
        if self.parked:
            return f"A wall of {size} is parked out of reach, so every beam reads 0."
        top = self.centre_height + self.height / 2
        return (
            f"A wall of {size}, without friction, its top at {top:g} m, "
            f"its center at x ~ U({self.nearest:g}, {self.farthest:g}) m, y 0, drawn at reset."
        )


class _OnTorso(RuntimeVariation):
    """A run-time variation of bodies with a torso that carries range beams."""

    @classmethod
    def fits(cls, body: Body) -> bool:
        """Returns whether the body can carry range beams."""
        return body.beams is not None


@dataclass(frozen=True)
class RangeSensor(_OnTorso):
    """Appends ten range beams from the torso to the observation.

    A beam is distance to the wall / 10 m, or 0.
    """

    def describe(self, body: Body, spec: mujoco.MjSpec) -> str:
        """Returns the documentation's sentence."""
        plane = "the world's x–z plane" if body.beams == "world" else "the torso's x–z plane"
        return f"Ten range beams in {plane}, −45° to +45°, up to 10 m, are appended to the observation."


@dataclass(frozen=True)
class SensorNoise(_OnTorso):
    """Delays the range sensor by one step, drops beams and adds normal noise.

    ``dropout`` is the probability that a beam reads 0, per beam and step. ``noise`` is the standard deviation
    of the noise on beams that hit, in units of 10 m.
    """

    dropout: float = 0.05
    noise: float = 0.02

    def __post_init__(self) -> None:
        set_positive(self, "dropout", "noise")
        if self.dropout > 1:
            raise BenchError(
                "bad-factor", f"SensorNoise's dropout is {self.dropout!r}.", hint="Give at most 1."
            )

    def describe(self, body: Body, spec: mujoco.MjSpec) -> str:
        """Returns the documentation's sentence."""
        return (
            f"The sensor is one step late. Each beam drops to 0 with probability {self.dropout:g}, "
            f"and N(0, {self.noise:g}²) is added to beams that hit."
        )
