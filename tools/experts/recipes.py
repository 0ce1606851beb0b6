"""The training runs as tables."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.tasks import FURTHER_LIMBS, LIMBS, Task, customize, task as published_task
from gym_extensions.catalog.variations import RangeSensor, Wall
from gym_extensions.errors import BenchError

FAMILIES = {
    "HumanoidStandup": "Standup",
    "HumanoidStandupAndRun": "Standup",
    **{body: body for body in ("Hopper", "Walker2d", "HalfCheetah", "Humanoid", "Striker", "Pusher")},
}
"""The name of the bodies whose policies fit each other, by body."""


@dataclass(frozen=True)
class Recipe:
    """One training run with the reference settings of TRPO.

    ``tasks`` are trained together, one after the other over the environments; ``HopperWall:0.12`` is the wall
    with its top at .12 m. ``parent`` is the candidate to start from: ``best:<task>`` is the best so far of a
    task, ``last:<run>`` the last checkpoint of a run.
    """

    name: str
    tasks: tuple[str, ...]
    parent: str | None = None
    steps: int = 500_000
    batch_steps: int = 2_000
    num_envs: int = 25
    checkpoint: int = 100_000  # steps between checkpoints
    value_batches: int = 5  # batches in which only the value function learns, after a start from a policy
    targets: tuple[str, ...] = ()  # tasks that the checkpoints are candidates for; the last task if empty
    bonus: tuple[tuple[str, float], ...] = ()  # weights of reward terms that are added in training


@dataclass(frozen=True)
class Meant:
    """What an expert of some tasks must do: a share of its episodes reaches a return."""

    tasks: tuple[str, ...]  # the beginnings of their names
    level: float  # the return
    share: float
    otherwise: str  # what an expert does that falls short


MEANT = (
    Meant(("HumanoidStandup",), 270_000.0, 0.5, "it sits; standing at 1 m gives 333 a step"),
    Meant(("HumanoidWall", "HumanoidNoisyWall"), 5_000.0, 0.25, "it falls at the wall"),
    Meant(("Humanoid",), 5_750.0, 0.5, "it stands and shuffles, or falls; 5,000 is for standing"),
    Meant(("HopperWall", "HopperNoisyWall"), 2_000.0, 0.25, "it rarely passes the wall"),
    Meant(("Walker2dWall", "Walker2dNoisyWall"), 2_500.0, 0.25, "it rarely passes the wall"),
    Meant(("HalfCheetahWall", "HalfCheetahNoisyWall"), 2_000.0, 0.5, "it rarely passes the wall"),
)
"""The first match holds; tasks without one have no condition."""


def meant(task: Task, returns: NDArray[Any]) -> str:
    """Why the episodes of an expert are not what its task is for; empty if they are."""
    for row in MEANT:
        if task.name.startswith(row.tasks):
            return row.otherwise if float(np.mean(returns >= row.level)) < row.share else ""
    return ""


def training_task(name: str) -> Task:
    """The task of a name in ``Recipe.tasks``."""
    base, _, top = name.partition(":")
    row = published_task(base)
    if not top:
        return row
    width = next(each.width for each in row.variations if isinstance(each, Wall))
    wall = Wall(width, centre_height=float(top) - Wall(width).height / 2)
    return customize(row.base, (RangeSensor(), wall))


def _large(name: str, tasks: tuple[str, ...], parent: str, steps: int, **others: Any) -> Recipe:
    """A run with large batches, which follow fewer noisy gradients."""
    size = {"batch_steps": 10_000, "num_envs": 100, "value_batches": 2, "checkpoint": 200_000}
    return Recipe(name, tasks, parent, steps=steps, **(size | others))


HUMANOID_BODIES = (
    *("HumanoidMotorNoise", "HumanoidGravityThreeQuarters"),
    *(f"Humanoid{size}{part}" for part in (*LIMBS, *FURTHER_LIMBS["Humanoid"]) for size in ("Small", "Big")),
)
HUMANOID_HARD = (
    *(f"Humanoid{part}" for part in ("SmallThigh", "BigThigh", "SmallFoot", "BigFoot", "SmallLeg")),
    *(f"HumanoidGravity{factor}" for factor in ("Half", "OneAndQuarter", "OneAndHalf")),
    *("HumanoidMotorNoise", "HumanoidSmallTorso"),
)
"""Those on which the policy of all bodies still falls."""
WALK = (("reward_forward", 3.0), ("reward_survive", -0.6))
"""Makes Humanoid's speed count four times as much, and standing less than half."""
FASTER = (("reward_forward", 9.0), ("reward_survive", -0.6))
"""The same with a speed that counts ten times as much."""
HOPPER_WALLS = ("HopperWall", "HopperNoisyWall")
HUMANOID_START = "stored:trpo/humanoid-body/sequential-run0-stage14"
TABLE = (
    _large("trpo-Humanoid-run", ("Humanoid",), HUMANOID_START, 2_000_000, bonus=WALK),
    _large("trpo-Humanoid-fast", ("Humanoid",), "last:trpo-Humanoid-run-seed0", 600_000, bonus=FASTER),
    _large(
        "trpo-Humanoid-bodies",
        HUMANOID_BODIES,
        "best:Humanoid",
        2_000_000,
        batch_steps=20_000,
        num_envs=96,
        checkpoint=1_000_000,
        targets=HUMANOID_BODIES,
        bonus=WALK,
    ),
    _large(
        "trpo-Humanoid-hard",
        HUMANOID_HARD,
        "last:trpo-Humanoid-bodies-seed0",
        1_200_000,
        batch_steps=20_000,
        checkpoint=600_000,
        targets=HUMANOID_HARD,
        bonus=WALK,
    ),
    _large(
        "trpo-HumanoidWall-joint",
        ("HumanoidWithSensor", "HumanoidWall"),
        "best:HumanoidWall",
        600_000,
        targets=("HumanoidWall", "HumanoidNoisyWall"),
    ),
    _large(
        "trpo-HalfCheetahWall-joint",
        ("HalfCheetahWithSensor", "HalfCheetahWall"),
        "best:HalfCheetahWall",
        4_000_000,
        batch_steps=20_000,
        targets=("HalfCheetahWall", "HalfCheetahNoisyWall"),
    ),
    Recipe(
        "trpo-HopperWall-mix",
        ("HopperWithSensor", "HopperWall:0.12", "HopperWall:0.22", "HopperWall"),
        "stored:trpo/hopper-body/sequential-run1-stage8",
        steps=1_000_000,
        num_envs=24,
        value_batches=10,
        targets=HOPPER_WALLS,
    ),
    _large(
        "trpo-HopperWall-low",
        ("HopperWithSensor", "HopperWall:0.1", "HopperWall:0.17", "HopperWall:0.24"),
        "best:Hopper",
        1_500_000,
        targets=HOPPER_WALLS[:1],
    ),
    _large(
        "trpo-HopperWall-high",
        ("HopperWithSensor", "HopperWall:0.24", "HopperWall:0.31", "HopperWall"),
        "last:trpo-HopperWall-low-seed0",
        2_000_000,
        targets=HOPPER_WALLS,
    ),
)
"""Walking, and ways over the walls."""
FURTHER = {"Hopper": 500_000, "Humanoid": 400_000, "Pusher": 1_500_000, "Striker": 1_000_000} | dict.fromkeys(
    ("Walker2d", "HalfCheetah", "Standup"), 600_000
)
"""Steps of ``trpo-<task>``, which trains the task's best candidate further on the task, by family."""


def recipe(name: str) -> Recipe:
    """A run of the table, or ``trpo-<task>``, which continues from the best candidate of the task.

    Raises ``BenchError`` if there is no such run.
    """
    for run in TABLE:
        if run.name == name:
            return run
    row = published_task(name.removeprefix("trpo-"))
    if row.base not in FAMILIES:
        raise BenchError("unknown-run", f"{name!r} is unknown: no experts are trained for {row.base}.")
    steps = FURTHER[FAMILIES[row.base]]
    return _large(name, (row.name,), f"best:{row.name}", steps, checkpoint=100_000)
