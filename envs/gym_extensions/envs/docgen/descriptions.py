"""What each variation of a task does, as sentences with numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from gym_extensions.catalog.task import Task
from gym_extensions.catalog.variations.actuation import MotorNoise
from gym_extensions.catalog.variations.goals import MovingGoal, MovingStart, TrackingGoal
from gym_extensions.catalog.variations.gravity import Gravity
from gym_extensions.catalog.variations.maps import Course
from gym_extensions.catalog.variations.morphology import PARTS, LimbScale, mass
from gym_extensions.catalog.variations.obstacles import RangeSensor, SensorNoise, Wall
from gym_extensions.envs.mujoco.compile import base_spec


def differences(task: Task) -> list[str]:
    """A sentence a variation; none for an unvaried body."""
    return [SENTENCES[type(variation)](variation, task) for variation in task.variations]


def _gravity(variation: Gravity, task: Task) -> str:
    spec = base_spec(task.base)
    before = spec.option.gravity[2]
    variation.apply(spec)
    return f"Gravity {spec.option.gravity[2]:g} m/s², {variation.factor:g} times {before:g}."


def _limb(variation: LimbScale, task: Task) -> str:
    spec = base_spec(task.base)
    geoms = [spec.geom(name) for name in PARTS[spec.modelname][variation.part]]
    total = sum(mass(geom) for geom in spec.geoms)
    scale = spec.compiler.settotalmass / total if spec.compiler.settotalmass > 0 else 1.0
    before = sum(mass(geom) for geom in geoms) * scale
    radii = ", ".join(
        f"{geom.name} {geom.size[0]:g} → {geom.size[0] * variation.factor:.6g} m" for geom in geoms
    )
    after = before * variation.factor
    return (
        f"{variation.part}: radius and mass times {variation.factor:g} "
        f"(radius: {radii}; mass {before:.4g} → {after:.4g} kg)."
    )


def _sensor(variation: RangeSensor, task: Task) -> str:
    fan = "the world's x–z plane" if "Standup" in task.base else "the torso's x–z plane"
    return f"Ten range beams in {fan}, −45° to +45°, up to 10 m, appended to the observation."


def _wall(variation: Wall, task: Task) -> str:
    size = f"{variation.depth:g} × {variation.width:g} × {variation.height:g} m (deep, wide, tall)"
    if variation.parked:
        return f"A wall of {size} is parked out of reach: every beam reads 0."
    top = variation.centre_height + variation.height / 2
    return (
        f"A wall of {size}, without friction, its top at {top:g} m, "
        f"its centre at x ~ U({variation.nearest:g}, {variation.farthest:g}) m, y 0, drawn at reset."
    )


def _sensor_noise(variation: SensorNoise, task: Task) -> str:
    return (
        f"The sensor reads one step late; each beam drops to 0 with probability {variation.dropout:g}, "
        f"and beams that hit carry N(0, {variation.noise:g}²)."
    )


def _motor_noise(variation: MotorNoise, task: Task) -> str:
    return (
        f"Every motor gets its command plus N(0, ({variation.scale:g} × its range)²), clipped to its range; "
        "all noise of an episode is drawn at reset."
    )


def _moving_goal(variation: MovingGoal, task: Task) -> str:
    return (
        "The goal is drawn at reset, at offsets y ~ U(−0.2, 0), x ~ U(−0.1, 0.3) from (0.45, −0.05); the "
        "object is then drawn until farther than 0.17 m from it."
    )


def _moving_start(variation: MovingStart, task: Task) -> str:
    return (
        "The ball is drawn at reset, x ~ U(0.43, 0.55), y ~ U(−0.3, −0.05); the goal is redrawn while within "
        "0.17 m of it."
    )


def _tracking(variation: TrackingGoal, task: Task) -> str:
    return (
        f"The goal moves during the episode: velocity components ~ U(−{variation.speed:g}, "
        f"{variation.speed:g}) m/s, drawn at reset, reflected at the box from which its place is drawn."
    )


def _course(variation: Course, task: Task) -> str:
    from gym_extensions.envs.navigation.grid import arena

    x, y = arena(variation.map, variation.goal).goal
    return f"Map {variation.map}, goal {variation.goal} at ({x:g}, {y:g})."


SENTENCES: dict[type, Callable[[Any, Task], str]] = {
    Gravity: _gravity,
    LimbScale: _limb,
    RangeSensor: _sensor,
    Wall: _wall,
    SensorNoise: _sensor_noise,
    MotorNoise: _motor_noise,
    MovingGoal: _moving_goal,
    MovingStart: _moving_start,
    TrackingGoal: _tracking,
    Course: _course,
}
"""The sentence of every kind of variation."""
