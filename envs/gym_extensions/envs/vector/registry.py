"""Which rules each base body follows, which parts a task's variations add, and which lanes go together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.actuation import MotorNoise
from gym_extensions.catalog.variations.base import AtRunTime
from gym_extensions.catalog.variations.goals import MovingGoal, MovingStart, TrackingGoal
from gym_extensions.catalog.variations.obstacles import RangeSensor, SensorNoise, Wall
from gym_extensions.envs.effects.vector_base import LanePart
from gym_extensions.envs.effects.vector_motion import NoisyMotors, TrackingGoals
from gym_extensions.envs.effects.vector_scenery import Beams, NoisyBeams, StandingWalls
from gym_extensions.envs.vector.arm import Pushing, Striking
from gym_extensions.envs.vector.humanoid import LyingDown, StandingUpToRun, Upright
from gym_extensions.envs.vector.physics import Physics
from gym_extensions.envs.vector.planar import Planar
from gym_extensions.envs.vector.rules import MakesRules
from gym_extensions.envs.vector.template import Prototype

Kind = TypeVar("Kind")

FAMILIES: dict[str, MakesRules] = {
    "Hopper": Planar,
    "Walker2d": Planar,
    "HalfCheetah": Planar,
    "Humanoid": Upright,
    "HumanoidStandup": LyingDown,
    "HumanoidStandupAndRun": StandingUpToRun,
    "Pusher": Pushing,
    "Striker": Striking,
}
"""The rules of every base body."""

SHARED = (RangeSensor, SensorNoise, MotorNoise, TrackingGoal)
"""Variations whose parts serve all lanes of a lot alike."""
AT_RUN_TIME = (*SHARED, MovingGoal, MovingStart)
"""Variations that act at run time and are known here."""

LAYOUT = (
    *("nq", "nv", "nu", "na", "nbody", "njnt", "ngeom", "nsite", "ncam", "nlight", "nmesh", "nmocap"),
    *("neq", "ntendon", "nsensor", "nsensordata", "nuserdata", "nplugin"),
)
"""Sizes of MjModel that simulations in one batch have in common."""


def stepped_at_once(task: Task) -> bool:
    """Whether there are whole-array rules for the task."""
    odd = any(isinstance(own, AtRunTime) and not isinstance(own, AT_RUN_TIME) for own in task.variations)
    return task.base in FAMILIES and not odd


def layout(lane: Prototype) -> tuple[object, ...]:
    """What lanes of a lot have in common: rules, parts and the sizes of everything simulated."""
    task, model = lane.task, lane.model
    sizes = tuple(int(getattr(model, name)) for name in LAYOUT)
    parts = tuple(sorted((own for own in task.variations if isinstance(own, SHARED)), key=repr))
    wall = variation(task, Wall)
    box = wall.half_sizes if wall is not None else None
    return task.base, task.max_steps, lane.frame_skip, model.opt.timestep, sizes, parts, box


def variation(task: Task, kind: type[Kind]) -> Kind | None:
    """The task's variation of a kind."""
    return next((own for own in task.variations if isinstance(own, kind)), None)


def parts(physics: Physics, lanes: Sequence[Prototype]) -> list[LanePart]:
    """The parts of a lot in the order in which they draw: walls, sensor, motors, goals."""
    task = lanes[0].task
    walls = [wall for lane in lanes if (wall := variation(lane.task, Wall)) is not None]
    found: list[LanePart] = [StandingWalls(walls)] if walls else []
    if variation(task, RangeSensor) is not None:
        noise = variation(task, SensorNoise)
        beams = Beams(physics, lanes, walls) if noise is None else NoisyBeams(physics, lanes, walls, noise)
        found.append(beams)
    if (motor := variation(task, MotorNoise)) is not None:
        found.append(NoisyMotors(lanes, motor))
    if (tracking := variation(task, TrackingGoal)) is not None:
        found.append(TrackingGoals(physics, lanes, tracking))
    return found
