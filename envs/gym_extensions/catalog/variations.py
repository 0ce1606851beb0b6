"""What can differ between a task and its base body: one class per variation, with all that it means.

A class says which bodies it fits, how it edits the model, and what it is to the reader, to pictures, to
landscapes and to the page Play. What it does while the simulation runs is an effect in ``envs.effects``.
"""

from __future__ import annotations

import contextlib
import functools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from decimal import Decimal
from typing import TYPE_CHECKING, Any, ClassVar, Literal, SupportsFloat

from gym_extensions.errors import BenchError, require_known

if TYPE_CHECKING:
    import mujoco

    from gym_extensions.catalog.bodies import Body

__all__ = [
    "Gravity",
    "LimbScale",
    "MotorNoise",
    "MovingGoal",
    "MovingStart",
    "RangeSensor",
    "SensorNoise",
    "TrackingGoal",
    "Wall",
]
"""The variations that users give to tasks; ``gym_extensions.envs`` exports them."""

Shown = Literal["", "parts", "wall", "beams", "goal", "start"]
"""What a picture shows: parts of a body, a wall, range beams, the area of a goal, the start of an object."""


@dataclass(frozen=True)
class Quantity:
    """A number that a variation sets, along which landscapes measure returns."""

    name: str  # short, in lower case
    title: str  # what varies, in words
    unit: str
    points: tuple[float, ...]  # the values at which returns are measured, ascending
    at: Callable[[float], Variation]  # the variation with another value
    trained: tuple[float, float] | None  # lowest and highest value in its task; None if it has none there
    unchanged: float | None = None  # the value of the base body; None if it has none


@dataclass(frozen=True)
class Variation:
    """A difference between a task and its base body.

    A variation is a frozen dataclass. This base class changes nothing, fits every body, and describes itself
    by its values. Variations of different parts give the same model in any order.
    """

    fits: ClassVar[Any] = staticmethod(lambda body: True)
    """Whether the variation can be applied to a base body: a function of the body, true or false."""
    needs: ClassVar[type[Variation] | None] = None
    """The variation on which it acts. A task must have that, too, and its own effect replaces that one's."""
    is_last: ClassVar[bool] = False
    """Whether it edits the model after all others."""
    sentence: ClassVar[str] = ""
    """The documentation's sentence, with the variation's values in braces."""
    shows: ClassVar[Shown] = ""
    """What of it a picture shows; empty if it is not seen."""
    signed: ClassVar[tuple[str, ...]] = ()
    """The numbers that may be 0 or negative."""
    largest: ClassVar[Mapping[str, float]] = {}
    """The largest value of the numbers that have one."""

    def __post_init__(self) -> None:
        """Stores all numbers as floats, so that equal numbers of any type give one task.

        Raises ``BenchError`` if a value is not a finite number, not above 0 where it must be, or too large.
        """
        for name in [each.name for each in fields(self) if each.type in ("float", float)]:
            value, number = getattr(self, name), math.nan
            with contextlib.suppress(TypeError, OverflowError):  # an array, a whole number beyond any float
                if isinstance(value, SupportsFloat) and not isinstance(value, bool):
                    number = float(value)
            low = -math.inf if name in self.signed else 0.0
            hint = "Give a finite number." if name in self.signed else "Give a finite number above 0."
            if number > (high := self.largest.get(name, math.inf)):
                hint = f"Give at most {high:g}."
            if not (math.isfinite(number) and low < number <= high):
                message = f"{type(self).__name__}'s {name} is {value!r}."
                raise BenchError("bad-factor", message, hint=hint)
            object.__setattr__(self, name, number)

    def apply(self, body: Body, spec: mujoco.MjSpec) -> None:
        """Edits the model's specification in place, before it is compiled."""

    def describe(self, body: Body, spec: mujoco.MjSpec) -> str:
        """Returns the documentation's sentence. ``spec`` is without variations; the method may edit it."""
        return self.sentence.format(**vars(self)) or f"{self!r}."

    def geoms(self, body: Body) -> tuple[str, ...]:
        """The names of the body's geoms that it changes, which pictures color."""
        return ()

    @property
    def quantity(self) -> Quantity | None:
        """The number along which landscapes of returns are measured; None if it has none."""
        return None

    @property
    def played(self) -> dict[str, object] | None:
        """What it sets in the world of the page Play (``static/play/world.js``); None if Play lacks it."""
        return None


@dataclass(frozen=True)
class Gravity(Variation):
    """Multiplies gravity, 9.81 m/s² straight down, by a factor (the paper's gravity tasks)."""

    factor: float
    fits = staticmethod(lambda body: body.has_gravity)

    @property
    def quantity(self) -> Quantity:
        """Gravity: the five factors of the tasks, the middles between them, and three at each end."""
        points = (*(0.3, 0.35, 0.4, 0.5, 0.625, 0.75, 0.875, 1.0), *(1.125, 1.25, 1.375, 1.5, 1.6, 1.65, 1.7))
        trained = self.factor, self.factor
        return Quantity("gravity", "gravity", "g", points, Gravity, trained, unchanged=1.0)

    @property
    def played(self) -> dict[str, object]:
        return {"gravity": self.factor}

    def apply(self, body: Body, spec: mujoco.MjSpec) -> None:
        """Multiplies z-gravity in decimal arithmetic: 9.81 × 1.25 is the float nearest 12.2625."""
        x, y, z = spec.option.gravity
        spec.option.gravity = [x, y, float(Decimal(repr(float(z))) * Decimal(repr(float(self.factor))))]

    def describe(self, body: Body, spec: mujoco.MjSpec) -> str:
        before = spec.option.gravity[2]
        self.apply(body, spec)
        return f"Gravity {spec.option.gravity[2]:g} m/s² ({self.factor:g} × {before:g}).".replace("-", "−")


@dataclass(frozen=True)
class LimbScale(Variation):
    """Multiplies the width and the mass of a body part by a factor (the paper: Big 1.25, Small 0.75).

    Width is the radius of a capsule or sphere. A capsule's length and end points stay. Inertia follows from
    the new shape and mass. Every other geom keeps its mass.
    """

    part: str
    factor: float

    fits = staticmethod(lambda body: body.parts)
    shows: ClassVar[Shown] = "parts"

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.part, str):
            raise BenchError("bad-value", f"LimbScale's part is {self.part!r}.", hint="Name one part.")

    def geoms(self, body: Body) -> tuple[str, ...]:
        return body.parts[self.part]

    @property
    def quantity(self) -> Quantity:
        """The width and mass of the part."""
        points = (0.6, 0.675, 0.75, 0.875, 1.0, 1.125, 1.25, 1.325, 1.4)
        part, trained = self.part.lower(), (self.factor, self.factor)
        at = functools.partial(LimbScale, self.part)
        return Quantity(part, f"width and mass of the {part}", "×", points, at, trained, unchanged=1.0)

    @property
    def played(self) -> dict[str, object]:
        return {"limbs": {self.part: self.factor}}

    def apply(self, body: Body, spec: mujoco.MjSpec) -> None:
        """Scales radius and mass of the part's geoms. Raises ``BenchError`` for an unknown part."""
        require_known("part", self.part, body.parts, body.name)
        geoms = [spec.geom(name) for name in body.parts[self.part]]
        before = {geom.name: mass(geom) for geom in geoms}
        # HalfCheetah's compiler scales all masses to a total, which rises so that no other mass moves.
        total = float(spec.compiler.settotalmass)
        if total > 0:
            increase = (self.factor - 1) * sum(before.values())
            masses = math.fsum(mass(geom) for geom in spec.geoms)
            spec.compiler.settotalmass = total + increase * total / masses
        for geom in geoms:
            geom.size[0] *= self.factor
            geom.mass = self.factor * before[geom.name]
        # Feet that touch in the rest pose and may collide would start an episode with a kick.
        if (feet := body.feet) is not None and not spec.excludes:
            first, second = feet.names
            if float(spec.geom(first).size[0]) + float(spec.geom(second).size[0]) > feet.distance:
                spec.add_exclude(bodyname1=first, bodyname2=second)

    def describe(self, body: Body, spec: mujoco.MjSpec) -> str:
        geoms = [spec.geom(name) for name in body.parts[self.part]]
        total = sum(mass(geom) for geom in spec.geoms)
        scale = spec.compiler.settotalmass / total if spec.compiler.settotalmass > 0 else 1.0
        before = sum(mass(geom) for geom in geoms) * scale
        sizes = [(geom.name, geom.size[0], geom.size[0] * self.factor) for geom in geoms]
        radii = ", ".join(f"{name} {old:g} → {new:.6g} m" for name, old, new in sizes)
        masses = f"mass {before:.4g} → {before * self.factor:.4g} kg"
        self.apply(body, spec)
        feet = " The feet do not collide with each other." if spec.excludes else ""
        return f"{self.part}: radius and mass × {self.factor:g} (radius: {radii}; {masses}).{feet}"


def mass(geom: mujoco.MjsGeom) -> float:
    """The geom's mass before compilation, kg: density × volume of a capsule or sphere if it is not set."""
    if not math.isnan(geom.mass):
        return float(geom.mass)
    radius, half_length = float(geom.size[0]), float(geom.size[1])
    if not math.isnan(geom.fromto[0]):
        half_length = math.dist(geom.fromto[:3], geom.fromto[3:]) / 2
    if geom.type.name == "mjGEOM_SPHERE":
        half_length = 0.0
    elif geom.type.name != "mjGEOM_CAPSULE":
        return 0.0  # the floor; the base bodies have no other shapes
    return float(geom.density) * math.pi * radius**2 * (2 * half_length + 4 / 3 * radius)


WALL = "wall"
"""Name of the wall's body and geom in the model."""
BOX = 6
"""MuJoCo's mjGEOM_BOX; the catalog loads no simulator."""


@dataclass(frozen=True)
class Wall(Variation):
    """A box across the way, its center at y = 0 and at x drawn from U(nearest, farthest) m at every reset.

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
    fits = staticmethod(lambda body: body.beams)
    is_last: ClassVar[bool] = True  # it keeps the extent of the model to which it is added
    shows: ClassVar[Shown] = "wall"
    signed: ClassVar[tuple[str, ...]] = ("centre_height",)

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.parked, bool):
            raise BenchError("bad-value", f"Wall's parked is {self.parked!r}.", hint="Give true or false.")
        if not self.farthest >= self.nearest:
            message = f"Wall's farthest is {self.farthest!r} and its nearest {self.nearest!r}."
            raise BenchError("bad-range", message, hint="Give farthest at least as large as nearest.")

    @property
    def quantity(self) -> Quantity:
        """The distance of its center from the start."""
        points = (1.2, 1.4, 1.6, 1.8, 2.3, 2.8, 3.3, 3.8, 4.2, 4.6, 5.0)
        trained = None if self.parked else (self.nearest, self.farthest)

        def at(distance: float) -> Wall:
            return replace(self, nearest=distance, farthest=distance, parked=False)

        return Quantity("wall", "distance of the wall", "m", points, at, trained)

    @property
    def played(self) -> dict[str, object]:
        return {"wall": not self.parked}

    @property
    def half_sizes(self) -> tuple[float, float, float]:
        """Half of the box's depth (x), width (y) and height (z), m."""
        return self.depth / 2, self.width / 2, self.height / 2

    def apply(self, body: Body, spec: mujoco.MjSpec) -> None:
        """Adds the box and keeps the model's extent and center, or the renderer would clip the agent.

        A contact takes the larger condim of its two geoms. Priority 1 gives the wall's condim 1, that is, no
        friction.
        """
        before = spec.copy().compile().stat
        spec.stat.extent, spec.stat.center = before.extent, before.center
        x, z = (self.nearest + self.farthest) / 2, self.centre_height  # before a reset draws x
        if self.parked:
            x, z = 0.0, -100.0  # no body and no beam reaches that far below the floor
        wall = spec.worldbody.add_body(name=WALL, mocap=True, pos=(x, 0.0, z))
        contact = {"contype": 1, "conaffinity": 1, "condim": 1, "priority": 1}
        look = {"material": "", "rgba": (0.75, 0.25, 0.55, 1)}
        wall.add_geom(name=WALL, type=BOX, size=self.half_sizes, mass=0, **contact, **look)

    def describe(self, body: Body, spec: mujoco.MjSpec) -> str:
        size = f"{self.depth:g} × {self.width:g} × {self.height:g} m (depth × width × height)"
        if self.parked:
            return f"A wall of {size} is parked out of reach, so every beam reads 0."
        top = self.centre_height + self.height / 2
        return (
            f"A wall of {size}, without friction, its top at {top:g} m, "
            f"its center at x ~ U({self.nearest:g}, {self.farthest:g}) m, y 0, drawn at reset."
        )


@dataclass(frozen=True)
class RangeSensor(Variation):
    """Appends ten range beams from the torso to the observation: distance to the wall / 10 m, or 0."""

    fits = staticmethod(lambda body: body.beams)
    shows: ClassVar[Shown] = "beams"

    @property
    def played(self) -> dict[str, object]:
        return {}

    def describe(self, body: Body, spec: mujoco.MjSpec) -> str:
        plane = "the world's x–z plane" if body.beams == "world" else "the torso's x–z plane"
        return f"Ten range beams in {plane}, −45° to +45°, up to 10 m, are appended to the observation."


@dataclass(frozen=True)
class SensorNoise(Variation):
    """Delays the range sensor by one step, drops beams and adds normal noise.

    ``dropout`` is the probability that a beam reads 0, per beam and step. ``noise`` is the standard deviation
    of the noise on beams that hit, in units of 10 m.
    """

    sentence: ClassVar[str] = (
        "Observations show the readings of the step before, the first one those at reset. Each beam drops "
        "to 0 with probability {dropout:g}, and N(0, {noise:g}²) is added to beams that hit."
    )
    fits = staticmethod(lambda body: body.beams)
    needs: ClassVar[type[Variation] | None] = RangeSensor
    largest: ClassVar[Mapping[str, float]] = {"dropout": 1.0}

    dropout: float = 0.05
    noise: float = 0.02


@dataclass(frozen=True)
class MotorNoise(Variation):
    """Adds normal noise of ``scale`` × the motor's range to every command, and clips the sum to the range.

    ``scale`` is the standard deviation of the noise as a fraction of the motor's range. Reward terms that
    use the action in Gymnasium use the command; terms that use ``ctrl`` use the noisy command.
    """

    sentence: ClassVar[str] = (
        "Noise from N(0, ({scale:g} × range)²) is added to every motor's command, and the sum is "
        "clipped to the motor's range. All noise of an episode is drawn at reset. In rewards, a is the "
        "command and ctrl what the motors receive."
    )
    fits = staticmethod(lambda body: body.family != "navigation")

    scale: float = 0.1


@dataclass(frozen=True)
class MovingGoal(Variation):
    """Draws Pusher's goal at every reset, then the object away from it (the paper's PusherMovingGoal)."""

    sentence: ClassVar[str] = (
        "The goal is drawn at reset, at offsets y ~ U(−0.2, 0), x ~ U(−0.1, 0.3) from (0.45, −0.05). "
        "The object is then drawn as in Pusher, until it is more than 0.17 m from the goal."
    )
    fits = staticmethod(lambda body: body.name == "Pusher")
    shows: ClassVar[Shown] = "goal"


@dataclass(frozen=True)
class MovingStart(Variation):
    """Draws Striker's ball at every reset, then the goal away from it (the paper's StrikerMovingStart)."""

    sentence: ClassVar[str] = (
        "The ball is drawn at reset, x ~ U(0.43, 0.55), y ~ U(−0.3, −0.05). The goal is drawn again "
        "while it is within 0.17 m of the ball."
    )
    fits = staticmethod(lambda body: body.name == "Striker")
    shows: ClassVar[Shown] = "start"


@dataclass(frozen=True)
class TrackingGoal(Variation):
    """Moves the goal inside a rectangle during the episode, at a velocity of up to ``speed`` m/s.

    The goal is reflected at the edges of the rectangle from which its start is drawn. Each component of the
    velocity is drawn at reset.
    """

    sentence: ClassVar[str] = (
        "The goal moves during the episode. Its velocity components are drawn at reset from "
        "U(−{speed:g}, {speed:g}) m/s, and it is reflected at the edges of the rectangle from "
        "which its start is drawn."
    )
    fits = staticmethod(lambda body: body.goal_area)
    shows: ClassVar[Shown] = "goal"
    # In a step of 0.05 s, it moves at most by the shortest side of a rectangle, 0.2 m.
    largest: ClassVar[Mapping[str, float]] = {"speed": 4.0}

    speed: float = 0.2


@dataclass(frozen=True)
class Course(Variation):
    """One navigation task, with the observation family and the numbers of the map and the goal."""

    family: str
    map: int
    goal: int
    fits = staticmethod(lambda body: body.family == "navigation")


KINDS: dict[str, type[Variation]] = {kind.__name__: kind for kind in Variation.__subclasses__()}
"""The variation classes by name, for example ``Gravity``."""
