"""Pusher, as in Gymnasium's pusher_v5, and Striker: Gym's Striker-v0 on a model rebuilt from Pusher's."""

import math
from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog import bodies, variations
from gym_extensions.envs.effects import variation_of
from gym_extensions.envs.interfaces import Array, Flags, Generators, Indices, Physics, Template
from gym_extensions.envs.mujoco.base import Rules

APART = 0.17
"""Least distance between object and goal at reset, m (the arm tasks of 2017 and of Gymnasium)."""
PUSHER_OBJECT = bodies.Rectangle((-0.3, -0.2), (0.0, 0.2))
"""Slide offsets (y, x) of Pusher's object."""
STRIKER_BALL = bodies.Rectangle((0.43, -0.3), (0.55, -0.05))
"""World (x, y) of StrikerMovingStart's ball."""
STRIKER_BALL_FIXED = (0.5, -0.175)
"""World (x, y) of Striker's ball."""


PUSHER_ARM_SPEED, STRIKER_ARM_SPEED = 0.005, 0.1
"""Largest speed of an arm joint at reset, rad/s (Gymnasium's pusher_v5, Gym's Striker-v0)."""
STRIKE = 0.1
"""The tip strikes the ball when their distance is below this, m."""
DISTANCE_WEIGHT, CTRL_WEIGHT, NEAR_WEIGHT = 3.0, 0.1, 0.5
ARM = 7
"""Joints of the arm, before those of the object."""


def draw_point(area: bodies.Rectangle, generator: np.random.Generator) -> Array:
    """Draws a point, (2,), uniformly from a rectangle, one coordinate after the other."""
    return np.array([generator.uniform(area.low[axis], area.high[axis]) for axis in (0, 1)])


def facing(ball: Array, goal: Array) -> Array:
    """The quaternion of a goal at (x, y) whose open side, −y at rest, faces a ball at (x, y)."""
    turn = math.atan2(ball[0] - goal[0], goal[1] - ball[1])
    return np.array([math.cos(turn / 2), 0.0, 0.0, math.sin(turn / 2)])


def distance(difference: Array) -> Array:
    """Length of each row in m, with the same bits on all processors, unlike ``numpy.linalg.norm``."""
    return np.sqrt(np.square(difference).sum(axis=-1))


class ArmRules(Rules):
    """The observation, with positions as the last evaluation left them."""

    fields: ClassVar[tuple[str, ...]] = ("xpos",)
    moving: ClassVar[type[variations.Variation]]
    """The variation with which the start of the goal or of the ball is drawn."""

    def __init__(self, physics: Physics, templates: Sequence[Template]) -> None:
        super().__init__(physics, templates)
        self._moving = [variation_of(template.task, self.moving) is not None for template in templates]
        positions, model = physics.field("xpos"), templates[0].model
        self._tip, self._object, self._goal = (
            positions[:, model.body(name).id] for name in ("tips_arm", "object", "goal")
        )

    def draw(self, indices: Indices, generators: Generators) -> dict[str, Array]:
        drawn = [self._draw(int(index), rng) for index, rng in zip(indices, generators, strict=True)]
        return {name: np.array([row[name] for row in drawn]) for name in drawn[0]}

    def _draw(self, index: int, generator: np.random.Generator) -> dict[str, Array]:
        raise NotImplementedError

    def _reward(self, far: Array, cost: NDArray[Any], near: Array) -> Array:
        self._terms = {"reward_dist": far, "reward_ctrl": cost, "reward_near": near}
        return far + cost + near

    def observe(self) -> Array:
        """The arm's positions and velocities, then the positions of tip, object and goal."""
        arm = self._qpos[:, :ARM], self._qvel[:, :ARM]
        return np.concatenate((*arm, self._tip, self._object, self._goal), axis=1)


class PusherRules(ArmRules):
    """Pusher's reward, from the distances object to goal and tip to object and a cost on the action.

    Episodes never terminate.
    """

    moving = variations.MovingGoal

    def _draw(self, index: int, generator: np.random.Generator) -> dict[str, Array]:
        """The goal if it moves, the object away from it, arm velocities."""
        template = self._templates[index]
        goal = draw_point(bodies.PUSHER_GOAL, generator) if self._moving[index] else np.zeros(2)
        position = draw_point(PUSHER_OBJECT, generator)
        while not np.linalg.norm(position - goal) > APART:
            position = draw_point(PUSHER_OBJECT, generator)
        noise = generator.uniform(-PUSHER_ARM_SPEED, PUSHER_ARM_SPEED, template.model.nv)
        qvel = template.init_qvel + noise
        qvel[-4:] = 0
        return {"qpos": np.concatenate((template.init_qpos[:-4], position, goal)), "qvel": qvel}

    def reward_and_termination(self, actions: NDArray[Any], ctrl: NDArray[Any]) -> tuple[Array, Flags]:
        """−distance of object and goal − .1·Σ action² − .5 × distance of tip and object."""
        near = -distance(self._object - self._tip) * NEAR_WEIGHT
        far = -distance(self._object - self._goal)
        cost = -np.square(actions).sum(axis=1) * CTRL_WEIGHT
        return self._reward(far, cost, near), np.zeros(len(near), np.bool_)


class StrikerRules(ArmRules):
    """Striker's reward, from the smallest distance of ball and goal so far and of tip to ball until struck.

    Episodes never terminate.
    """

    moving = variations.MovingStart
    kept: ClassVar[tuple[str, ...]] = ("_best", "_struck", "_strike_place")

    def __init__(self, physics: Physics, templates: Sequence[Template]) -> None:
        super().__init__(physics, templates)
        self._best = np.full(len(templates), np.inf)
        self._struck = np.zeros(len(templates), np.bool_)
        self._strike_place = np.zeros((len(templates), 3))

    def _draw(self, index: int, generator: np.random.Generator) -> dict[str, Array]:
        """The ball if it moves, the goal away from it and facing it, arm velocities."""
        template = self._templates[index]
        ball = draw_point(STRIKER_BALL, generator) if self._moving[index] else np.array(STRIKER_BALL_FIXED)
        goal = draw_point(bodies.STRIKER_GOAL, generator)
        while not np.linalg.norm(ball - goal) >= APART:
            goal = draw_point(bodies.STRIKER_GOAL, generator)
        qvel = template.init_qvel.copy()
        qvel[:ARM] = generator.uniform(-STRIKER_ARM_SPEED, STRIKER_ARM_SPEED, ARM)
        qpos = np.concatenate((template.init_qpos[:ARM], ball[::-1]))
        is_mocap = template.model.body_mocapid >= 0  # the goal, before a user's own bodies
        position, turn = template.model.body_pos[is_mocap], template.model.body_quat[is_mocap]
        position[0, :2], turn[0] = goal, facing(ball, goal)
        return {"qpos": qpos, "qvel": qvel, "mocap_pos": position, "mocap_quat": turn}

    def on_reset(self, indices: Indices) -> None:
        """Clears the record of the episode. The distance at reset counts."""
        self._struck[indices], self._strike_place[indices] = False, 0.0
        self._best[indices] = self._ball_to_goal()[indices]

    def _ball_to_goal(self) -> Array:
        return distance(self._object - self._goal)

    def reward_and_termination(self, actions: NDArray[Any], ctrl: NDArray[Any]) -> tuple[Array, Flags]:
        """−3 × best distance − .1·Σ action² − .5 × distance of ball and tip (where it struck, if it has)."""
        self._best = np.minimum(self._best, self._ball_to_goal())
        within = distance(self._tip - self._object) < STRIKE
        self._struck |= within
        self._strike_place[within] = self._tip[within]
        near = distance(self._object - np.where(self._struck[:, None], self._strike_place, self._tip))
        cost = -CTRL_WEIGHT * np.square(actions).sum(axis=1)
        far, near = -DISTANCE_WEIGHT * self._best, -NEAR_WEIGHT * near
        return self._reward(far, cost, near), np.zeros(len(near), np.bool_)
