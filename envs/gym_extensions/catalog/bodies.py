"""The base bodies: all differences between them, as data."""

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal, TypeAlias

IS_SUCCESS = "is_success"
"""The key of a step's info. In vector infos, ``_is_success`` marks the environments that report it."""


@dataclass(frozen=True)
class Arrival:
    """The step terminates the episode."""

    sentence: str


@dataclass(frozen=True)
class Distance:
    """The centers of two bodies of the model are at most ``limit`` m apart in the x–y plane."""

    bodies: tuple[str, str]
    limit: float
    sentence: str


@dataclass(frozen=True)
class Height:
    """The height of the free root is between ``low`` and ``high`` m, exclusive."""

    low: float
    high: float
    sentence: str


Success: TypeAlias = Arrival | Distance | Height
"""When ``info["is_success"]`` is true after a step. An episode is a success if its last step is.

``sentence`` is that of the documentation. A body's success is part of its tasks: a change needs a new
version of each of them, although fingerprints do not contain it.
"""


Family = Literal["planar", "humanoid", "arm", "navigation", "gymnasium"]
"""Bodies of one family share the layout of their observations, except ``gymnasium``, the environments of
other packages."""
Frame = Literal["pitch", "torso", "world"]
"""The frame in which range beams are fixed: the planar root, the free torso, or the world."""
DEFAULT_MAX_STEPS = 1000


@dataclass(frozen=True)
class RewardBounds:
    """Lowest and highest reward per step."""

    low: float
    high: float
    terminates: bool = True  # False if only the time limit ends an episode
    end: float = 0.0  # added once, by the step that terminates the episode


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


TEXTS = Path(__file__).with_name("prose.toml").read_text(encoding="utf-8")
PROSE = {name: Prose(**texts) for name, texts in tomllib.loads(TEXTS).items()}
"""The text about every base body."""


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
    """Two feet that would touch in the rest pose if they were bigger."""

    names: tuple[str, str]
    distance: float  # between their centers, m


@dataclass(frozen=True)
class Health:
    """Open intervals of the root, outside which a body is not healthy."""

    height: tuple[float, float]  # m
    angle: tuple[float, float] = (-math.inf, math.inf)  # of a planar root, rad
    state: float | None = None  # bounds the size of all other coordinates of a planar body


@dataclass(frozen=True)
class Rectangle:
    """An axis-aligned rectangle, lower and upper corner in m."""

    low: tuple[float, float]
    high: tuple[float, float]


@dataclass(frozen=True)
class Body:
    """One base body."""

    name: str  # in tasks, for example ``HalfCheetah``
    family: Family
    asset: str  # file name of the model among Gymnasium's MuJoCo assets; empty without a model
    rewards: RewardBounds
    camera: Camera | None = None  # None without a picture
    max_steps: int = DEFAULT_MAX_STEPS
    parts: Mapping[str, tuple[str, ...]] = field(default_factory=dict)  # geoms that ``LimbScale`` changes
    feet: Feet | None = None  # whose contact is excluded when ``LimbScale`` makes them overlap
    has_gravity: bool = True
    beams: Frame | None = None  # of the range beams; None if the body has no torso to carry them
    wall_width: float | None = None  # of the published wall, m; None without a wall task
    velocity_limit: float | None = None  # Gymnasium clips observed velocities to this magnitude
    frame_skip: int = 5  # physics steps per environment step
    noise: float = 1e-2  # of a start; this and what follows: of planar bodies and humanoids
    ctrl_cost: float = 0.1  # weight of the squared actions
    health: Health | None = None  # None for a body that is always healthy
    goal_area: Rectangle | None = None  # within which a moving goal stays; None without a goal
    success: Success | None = None  # None if its tasks define no success

    @property
    def prose(self) -> Prose:
        """Its text in the documentation. Bodies of other packages have none."""
        return PROSE[self.name]


HOPPER = Body(
    name="Hopper",
    family="planar",
    asset="hopper.xml",
    rewards=RewardBounds(-20.0, 20.0),  # 1 for health, plus the forward speed in m/s
    camera=Camera(0.0, 0.65, 2.6, 90, -8),
    parts={name: (f"{name.lower()}_geom",) for name in ("Torso", "Thigh", "Leg", "Foot")},
    beams="pitch",
    wall_width=0.8,
    velocity_limit=10.0,
    frame_skip=4,
    noise=5e-3,
    ctrl_cost=1e-3,
    health=Health((0.7, math.inf), (-0.2, 0.2), 100.0),
)
WALKER = replace(
    HOPPER,
    name="Walker2d",
    asset="walker2d_v5.xml",
    rewards=RewardBounds(-25.0, 25.0),
    parts={"Torso": ("torso_geom",)}
    | {name: (f"{name.lower()}_geom", f"{name.lower()}_left_geom") for name in ("Thigh", "Leg", "Foot")},
    health=Health((0.8, 2.0), (-1.0, 1.0)),
)
CHEETAH = Body(
    name="HalfCheetah",
    family="planar",
    asset="half_cheetah.xml",
    rewards=RewardBounds(-50.0, 50.0, terminates=False),  # the forward speed in m/s
    camera=Camera(0.0, 0.45, 2.8, 90, -8),
    parts={
        "Torso": ("torso",),
        "Thigh": ("fthigh", "bthigh"),
        "Leg": ("fshin", "bshin"),
        "Foot": ("ffoot", "bfoot"),
        "Head": ("head",),
    },
    beams="pitch",
    wall_width=0.8,
    noise=0.1,
)

HUMANOID = Body(
    name="Humanoid",
    family="humanoid",
    asset="humanoid.xml",
    rewards=RewardBounds(-50.0, 50.0),  # 5 for health, 1.25 × speed in m/s, contact cost at most 10
    camera=Camera(0.0, 0.85, 3.0, 120, -8),
    parts={
        "Torso": ("torso1", "uwaist", "lwaist"),
        "Thigh": ("right_thigh1", "left_thigh1", "butt"),
        "Leg": ("right_shin1", "left_shin1"),
        "Foot": ("right_foot", "left_foot"),
        "Head": ("head",),
        "Arm": ("right_uarm1", "right_larm", "left_uarm1", "left_larm"),
        "Hand": ("right_hand", "left_hand"),
    },
    feet=Feet(("right_foot", "left_foot"), distance=0.18),
    beams="torso",
    wall_width=10.0,  # it would walk around a narrower one
    health=Health((1.0, 2.0)),
)
STANDUP = replace(
    HUMANOID,
    name="HumanoidStandup",
    asset="humanoidstandup.xml",
    rewards=RewardBounds(-100.0, 1500.0, terminates=False),  # height / 0.003 s: 1 m gives 333
    camera=Camera(0.4, 0.2, 3.0, 110, -20),
    beams="world",
    success=Height(
        low=1.0,
        high=2.0,
        sentence="At the last step, the height of the torso is in (1, 2) m, "
        "where Humanoid counts as healthy.",
    ),
)
STANDUP_AND_RUN = replace(
    STANDUP,
    name="HumanoidStandupAndRun",
    rewards=RewardBounds(-200.0, 1600.0, terminates=False),  # the sum of the two above
)

PUSHER_GOAL = Rectangle((-0.2, -0.1), (0.0, 0.3))
"""Slide offsets (y, x) of Pusher's moving goal."""
STRIKER_GOAL = Rectangle((0.15, 0.1), (0.7, 1.0))
"""World (x, y) of Striker's goal."""
SUCCESS_DISTANCE = 0.05
"""In m: the ``distance_threshold`` of Gymnasium-Robotics' FetchPush, and the radius of object and ball."""
IS_CLOSE = "At the last step, the centers of {} and goal are at most 0.05 m apart on the table."
PUSHER = Body(
    name="Pusher",
    family="arm",
    asset="pusher_v5.xml",
    rewards=RewardBounds(-30.0, 0.0, terminates=False),  # minus distances in m, minus squared actions
    # From above, so that arm, object and goal do not hide each other.
    camera=Camera(0.4, -0.35, 2.6, 100, -62, after_reset=True),
    max_steps=100,
    has_gravity=False,
    goal_area=PUSHER_GOAL,
    success=Distance(("object", "goal"), SUCCESS_DISTANCE, IS_CLOSE.format("object")),
)
STRIKER = replace(
    PUSHER,
    name="Striker",
    rewards=RewardBounds(-200.0, 0.0, terminates=False),  # as Pusher; the ball may fly off the table
    goal_area=STRIKER_GOAL,
    success=Distance(("object", "goal"), SUCCESS_DISTANCE, IS_CLOSE.format("ball")),
)
NAVIGATION = Body(
    name="Navigation",
    family="navigation",
    asset="",
    rewards=RewardBounds(-6.0, -1.0, end=10.0),  # −1 per step, −5 per collision, +10 at the goal
    has_gravity=False,
    success=Arrival("The episode ends at the goal."),
)

ROWS = (HOPPER, WALKER, CHEETAH, HUMANOID, STANDUP, STANDUP_AND_RUN, PUSHER, STRIKER, NAVIGATION)
BODIES: dict[str, Body] = {each.name: each for each in ROWS}
"""Every base body by its name."""
