"""A wall in the way, and the range sensor that sees it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from gym_extensions.catalog.variations.base import AtRunTime, positive
from gym_extensions.errors import BenchError

if TYPE_CHECKING:
    import mujoco

WALL = "wall"
"""Name of the wall's body and geom in the model."""
PARKED_HEIGHT = -100.0
"""Where a parked wall's centre lies, m: no body and no beam reaches that far below the floor."""
BOX = 6
"""MuJoCo's mjGEOM_BOX; the catalog loads no simulator."""


@dataclass(frozen=True)
class Wall:
    """A box across the way, its centre at y 0 and an x drawn at every reset from U(nearest, farthest).

    It is a mocap body added last to the world, without mass and without friction. Lengths in m. A parked wall
    lies out of reach under the floor: the task then shares the layout of the one in which it stands.
    """

    width: float = 0.8
    depth: float = 0.4
    height: float = 0.5
    centre_height: float = 0.125
    nearest: float = 1.8
    farthest: float = 3.8
    parked: bool = False

    def __post_init__(self) -> None:
        for name in ("width", "depth", "height", "nearest"):
            positive(f"Wall's {name}", getattr(self, name))
        if not self.farthest >= self.nearest:
            message = f"Wall's farthest is {self.farthest!r}, below its nearest, {self.nearest!r}."
            raise BenchError("bad-range", message, hint="Give the farthest place last.")

    @property
    def half_sizes(self) -> tuple[float, float, float]:
        """Half of the box's depth (x), width (y) and height (z), m."""
        return self.depth / 2, self.width / 2, self.height / 2

    @property
    def rest(self) -> tuple[float, float, float]:
        """Where the model places the centre before a reset draws its x."""
        if self.parked:
            return 0.0, 0.0, PARKED_HEIGHT
        return (self.nearest + self.farthest) / 2, 0.0, self.centre_height

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Adds the box. The model's extent and centre stay, or the renderer would clip the agent.

        Condim 1 with priority 1: a contact takes the larger condim of the pair, so without the priority some
        bodies would rub against it.
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


@dataclass(frozen=True)
class RangeSensor(AtRunTime):
    """Ten range beams from the torso, appended to the observation: distance to the wall / 10 m, or 0."""


@dataclass(frozen=True)
class SensorNoise(AtRunTime):
    """The range sensor reads one step late; beams drop out and carry normal noise.

    ``dropout`` is each beam's probability of reading 0, ``noise`` the standard deviation of what is added to
    the readings of beams that hit.
    """

    dropout: float = 0.05
    noise: float = 0.02

    def __post_init__(self) -> None:
        positive("SensorNoise's dropout", self.dropout)
        positive("SensorNoise's noise", self.noise)
        if self.dropout > 1:
            raise BenchError(
                "bad-factor", f"SensorNoise's dropout is {self.dropout!r}.", hint="Give at most 1."
            )
